// What the sound costs and how true it is: work-precision rows for `typodont bench`.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace typodont::audio {

/// One row: at this setting of the knob, this error for this time.
struct BenchRow {
  std::string name;        // "filter block float", "model", "synth working" …
  std::string knob;        // "order 300"
  double error = 0;        // in the unit that follows; 0 where there is nothing to compare with
  std::string error_unit;  // "relative rms", "dB log-spectral", "Itakura-Saito"
  double time_ns = 0;      // per sample, CPU time of the thread, median of the repeats
  std::string baseline;    // what the ratio is to
  double ratio = 0;        // time over the baseline's
};

struct BenchOptions {
  std::filesystem::path recording;  // that the models are fitted to
  std::vector<int> orders = {4, 16, 50, 100, 200, 300, 400, 600};
  int repeats = 9;
  int samples = 16384;  // a repeat
};

/// Throws Error as fit_recording does.
std::vector<BenchRow> audio_bench(const BenchOptions& options);

}  // namespace typodont::audio
