// The parts of `typodont bench`. A part measures errors and times, and returns them as rows. In the same run, it also
// measures baselines (other methods for the same task). The code of a part is in the module that it measures, or in
// this folder if the part needs several modules.
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "engine/contract/bench_row.h"
#include "haptics/contact_method.h"

namespace typodont {

/// Arguments that every part of the benchmark gets.
struct BenchRun {
  bool quick = false;                   // true: the part makes fewer repeats, for a short run
  haptics::SharedContactMethod method;  // contact model, for parts that measure one; null: the default model
  std::vector<std::string> tissues;     // names of the tissues of the part `models`; empty: all
};

struct BenchPart {
  std::string_view name;
  std::string_view title;
  std::string_view what;  // text for the page that says what the part measures
  /// Returns the measured rows. Throws Error if a required file or device is missing.
  std::vector<BenchRow> (*rows)(const BenchRun& run);
  bool takes_model = false;  // true: the part uses BenchRun::method
  /// Writes the part's rows as a separate page; null: the rows are a section of the common page.
  void (*write_page)(const std::filesystem::path& file, const std::vector<BenchRow>& rows,
                     const std::string& machine) = nullptr;
  /// Returns the table of the part's section, in Markdown; null: one line per row, with all columns.
  std::string (*table)(const std::vector<BenchRow>& rows) = nullptr;
};

std::span<const BenchPart> bench_parts();

// Functions that measure the rows of one part each. They are implemented in this folder.
std::vector<BenchRow> bench_mesh_picture(const BenchRun& run);
std::vector<BenchRow> bench_looks(const BenchRun& run);
std::vector<BenchRow> bench_render(const BenchRun& run);
std::vector<BenchRow> bench_import(const BenchRun& run);
std::vector<BenchRow> bench_recording(const BenchRun& run);
std::vector<BenchRow> bench_latency(const BenchRun& run);
std::vector<BenchRow> bench_length(const BenchRun& run);
std::vector<BenchRow> bench_push(const BenchRun& run);
std::vector<BenchRow> bench_scaling(const BenchRun& run);
std::vector<BenchRow> bench_stability(const BenchRun& run);
std::vector<BenchRow> bench_surface(const BenchRun& run);
std::vector<BenchRow> bench_undo(const BenchRun& run);

}  // namespace typodont
