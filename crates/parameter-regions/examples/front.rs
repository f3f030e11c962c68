//! The trade-off between two criteria that pull a parameter in opposite directions.

use parameter_regions::pareto::front;

fn main() {
    // Distances from two measured values, in tolerances, over one parameter: no value of it meets both exactly.
    let parameter: Vec<f64> = (0..=20).map(|k| f64::from(k) / 10.0).collect();
    let distances: Vec<Vec<f64>> = parameter.iter().map(|x| vec![(x - 0.5).abs(), (x * x - 2.0).abs()]).collect();
    println!("parameter  first  second   (tolerances)");
    for point in front(&distances) {
        let [first, second] = [distances[point][0], distances[point][1]];
        println!("{:9.2}  {first:5.2}  {second:6.2}", parameter[point]);
    }
}
