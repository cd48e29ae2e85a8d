// Where the rows of a table of `typodont bench` come from: the text in the first line of its CSV file.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace typodont {

/// One measurement that gave rows of a table.
struct RowOrigin {
  std::string made;  // program, processor, date, compiler and flags of the measurement
  // parts or tissues that were measured; empty: all parts that no other RowOrigin names
  std::vector<std::string> names;
};

/// Reads the first line of a table: "MADE (NAME, NAME); MADE (NAME); all other parts: MADE". MADE is the text
/// RowOrigin::made of a measurement, and the NAMEs in the brackets are the parts or tissues that it measured.
std::vector<RowOrigin> origins_of(std::string_view text);
/// Returns the text for a table's first line.
std::string text_of(const std::vector<RowOrigin>& origins);

/// Combines equal origins of rows to one. `origins`: the newest first. A part or tissue that several origins name is
/// kept only in the newest of them. Origins with the same text `made` become one origin. An origin without names (all
/// other parts) is moved to the end.
std::vector<RowOrigin> joined(const std::vector<RowOrigin>& origins);

}  // namespace typodont
