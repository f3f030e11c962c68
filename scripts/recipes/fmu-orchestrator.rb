# The Homebrew formula. `scripts/release` writes it into dist/release with version and checksum.
class FmuOrchestrator < Formula
  desc "Verifies FMUs against measurements under uncertainty"
  homepage "https://github.com/plain-bearing/plain-bearing-stand"
  url "https://github.com/plain-bearing/plain-bearing-stand/releases/download/v@VERSION@/fmu_orchestrator-@VERSION@.tar.gz"
  sha256 "@SHA256@"
  license "MIT"

  depends_on "rust" => :build
  # It packs the FMU.
  uses_from_macos "python" => :build

  def install
    cd "sources" do
      system "cargo", "install", *std_cargo_args(path: "orchestrator")
      system "cargo", "build", "--profile", "fmu", "--locked", "--package", "plain-bearing-stand"
      # The shipped studies look for the FMU beside them.
      system "python3", "scripts/package-fmu", "--local", "target/fmu/#{shared_library("libplain_bearing_stand")}",
             "--output", pkgshare/"dist/PlainBearingStand.fmu"
      pkgshare.install "studies"
    end
    generate_completions_from_executable(bin/"orchestrator", "completion")
    system bin/"orchestrator", "manual", man1
  end

  test do
    system bin/"orchestrator", "check", pkgshare/"dist/PlainBearingStand.fmu"
    system bin/"orchestrator", "verify", pkgshare/"studies/paper-table3.toml", "--points", "50", "--output", testpath/"results"
    assert_path_exists testpath/"results/report.html"
  end
end
