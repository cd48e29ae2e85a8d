// docs/performance.md: the rows of `typodont bench` as tables and plots. Made by the program, never typed by hand.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "engine/app/bench/parts.h"

namespace typodont {

struct MeasuredPart {
  const BenchPart* part = nullptr;
  std::vector<BenchRow> rows;
};

/// How the time of the rows called `name` grows with their size: the exponent b of a least-squares fit time ∝ size^b in
/// logarithms. NaN when there are not two sizes.
double growth_exponent(const std::vector<BenchRow>& rows, const std::string& name);

/// Writes FILE.md and, beside it in a folder of its name, one SVG per plot; whole or not at all, file by file. A part
/// with a page of its own (BenchPart::write_page) gets it beside FILE.md under the part's name, or as FILE.md where it
/// is the only part.
/// `machine`: processor, compiler, flags and date in one line. Throws Error when the place is not writable.
void write_performance_page(const std::filesystem::path& file, const std::vector<MeasuredPart>& parts,
                            const std::string& machine);

}  // namespace typodont
