// The columns of a session's tables. A column has a name, a unit, a meaning, and functions that convert it from and to
// a message.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string>
#include <vector>

#include "engine/contract/contact.h"

namespace typodont::session {

enum class Type : std::uint8_t { kF64, kI64, kU64, kU32, kU8 };

constexpr std::size_t size_of(Type type) {
  switch (type) {
    case Type::kU32:
      return 4;
    case Type::kU8:
      return 1;
    default:
      return 8;
  }
}
template <class T>
constexpr Type type_of() {
  if constexpr (std::is_same_v<T, double>) return Type::kF64;
  if constexpr (std::is_same_v<T, std::int64_t>) return Type::kI64;
  if constexpr (std::is_same_v<T, std::uint64_t>) return Type::kU64;
  if constexpr (std::is_same_v<T, std::uint32_t>) return Type::kU32;
  if constexpr (sizeof(T) == 1) return Type::kU8;
}

/// A column of the table of `Message`, which is ServoTick, Cut or PatchUse.
template <class Message>
struct Column {
  std::string name;
  std::string unit;  // unit of the column's numbers; empty if they have no unit
  std::string text;  // meaning of the column, in one line
  Type type = Type::kF64;
  void (*get)(const Message&, std::byte*) = nullptr;
  // stores a value from the file in a message; null if the column is computed from other columns
  void (*set)(Message&, const std::byte*) = nullptr;
  bool in_csv = true;
  bool in_file = true;
  // True if the column was added after the first release. Older files do not have this column; the message then keeps
  // its default value.
  bool added = false;
};

const std::vector<Column<ServoTick>>& tick_columns();
const std::vector<Column<Cut>>& cut_columns();
const std::vector<Column<PatchUse>>& patch_columns();

/// Returns the text of the attribute `labels` for columns that contain tissues: "0 air, 1 enamel, …".
std::string tissue_labels();
/// Returns the bits and names of the faults: "1 bad_input, 2 stale_patch, …".
std::string fault_labels();

}  // namespace typodont::session
