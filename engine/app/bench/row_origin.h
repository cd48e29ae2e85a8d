// Where the rows of a table of `typodont bench` come from: the text in the first line of its CSV file.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace typodont {

/// One measurement that gave rows of a table.
struct RowOrigin {
  std::string made;                // program, processor, date, compiler and flags of the measurement
  std::vector<std::string> names;  // parts or tissues that were measured; empty: all that are in no other RowOrigin
};

/// Reads the text of a table's first line: "MADE (NAME, NAME); MADE (NAME); all other parts: MADE".
std::vector<RowOrigin> origins_of(std::string_view text);
/// Returns the text for a table's first line.
std::string text_of(const std::vector<RowOrigin>& origins);

/// Joins the origins of rows, without repetitions. `origins`: the newest first. If several origins contain the same
/// name, the name stays only in the first of them. Origins with the same text `made` become one. An origin without
/// names is moved to the end.
std::vector<RowOrigin> joined(const std::vector<RowOrigin>& origins);

}  // namespace typodont
