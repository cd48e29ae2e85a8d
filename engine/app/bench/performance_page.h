// Generates docs/performance.md: the rows of `typodont bench` as tables and plots.
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "engine/app/bench/parts.h"

namespace typodont {

struct MeasuredPart {
  const BenchPart* part = nullptr;
  std::vector<BenchRow> rows;
};

/// Returns how fast the time grows with the size for the rows named `name`: the exponent b of a least-squares fit time
/// ∝ size^b on logarithmic scales. NaN if there are fewer than two sizes.
double growth_exponent(const std::vector<BenchRow>& rows, const std::string& name);

/// Returns a Markdown table of the rows in which a method of another program is faster than this program. If there is
/// no such row, returns a sentence that says so.
std::string slower_table(std::span<const MeasuredPart> parts);

/// Writes FILE.md and one SVG per plot, in a folder of the same name beside it. Each file is written completely or not
/// at all. A part of the benchmark can have a page of its own (BenchPart::write_page). This page is written beside
/// FILE.md under the part's name, or to FILE.md itself if there is no other part. `machine`: processor, compiler, flags
/// and date in one line. Throws Error if a file cannot be written.
void write_performance_page(const std::filesystem::path& file, const std::vector<MeasuredPart>& parts,
                            const std::string& machine);

}  // namespace typodont
