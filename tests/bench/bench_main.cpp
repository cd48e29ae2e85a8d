// main() of the benchmark programs. Options: `--smoke`, and those of google-benchmark. Exits with 1 if a claim of a
// case does not hold, or if a result is not finite.
#include <cstdlib>
#include <fstream>
#include <string_view>

#include "engine/base/error.h"
#include "tests/bench/bench.h"

namespace typodont::bench {

namespace {

bool smoke_run = false;
std::vector<std::string> failures;

/// Prints results on the terminal, and reports those that are not finite.
class Reporter : public benchmark::ConsoleReporter {
 public:
  Reporter() : ConsoleReporter(OO_None) {}
  void ReportRuns(const std::vector<Run>& runs) override {
    for (const Run& run : runs) {
      if (run.error_occurred) failures.push_back(run.benchmark_name() + ": " + run.error_message);
      require(std::isfinite(run.GetAdjustedRealTime()), run.benchmark_name() + ": the time is finite");
      for (const auto& [name, counter] : run.counters)
        require(std::isfinite(counter.value), run.benchmark_name() + ": " + name + " is finite");
    }
    ConsoleReporter::ReportRuns(runs);
  }
};

std::string processor() {
  std::ifstream info("/proc/cpuinfo");
  for (std::string line; std::getline(info, line);)
    if (line.starts_with("model name")) return line.substr(line.find(':') + 2);
  return "unknown processor";
}

}  // namespace

bool smoke() {
  return smoke_run;
}

void require(bool holds, const std::string& claim) {
  if (!holds) failures.push_back(claim);
}

void add(const std::string& name, Work work) {
  const auto once = [name, work = std::move(work)](benchmark::State& state) {
    for ([[maybe_unused]] const auto _ : state) {
      try {
        work(state);
      } catch (const Error& error) {
        require(false, name + ": " + error.what());
      }
    }
  };
  benchmark::RegisterBenchmark(name.c_str(), once)->Iterations(1)->UseManualTime();
}

}  // namespace typodont::bench

int main(int argc, char** argv) {
  using namespace typodont::bench;
  const auto end = std::remove_if(argv + 1, argv + argc, [](std::string_view option) {
    smoke_run |= option == "--smoke";
    return option == "--smoke";
  });
  argc = static_cast<int>(end - argv);
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 2;
  const char* const commit = std::getenv("TYPODONT_COMMIT");  // set by ./run bench
  benchmark::AddCustomContext("commit", commit ? commit : "unknown");
  benchmark::AddCustomContext("processor", processor());
  benchmark::AddCustomContext("compiler", "GCC " __VERSION__);
  add_cases();
  Reporter reporter;
  benchmark::RunSpecifiedBenchmarks(&reporter);
  for (const std::string& failure : failures) fmt::print(stderr, "does not hold: {}\n", failure);
  return failures.empty() ? 0 : 1;
}
