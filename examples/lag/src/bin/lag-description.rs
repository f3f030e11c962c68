//! Prints the lag's model description, which makes an FMU of its library.

fn main() {
    print!("{}", fmu_export::fmi2::description::xml::<lag::Lag>());
}
