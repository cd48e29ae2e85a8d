// Columns of a session's tables: name, unit, meaning and conversion.
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

/// A column in a table of messages (ServoTick, Cut or PatchUse).
template <class Message>
struct Column {
  std::string name;
  std::string unit;  // empty: the column has no unit
  std::string text;  // meaning of the column, in one line
  Type type = Type::kF64;
  void (*get)(const Message&, std::byte*) = nullptr;
  // Copies a value from the file to the message. Null: the column is computed from other columns.
  void (*set)(Message&, const std::byte*) = nullptr;
  bool in_csv = true;
  bool in_file = true;
  // True: the column was added after the first release. If an older file lacks it, the message keeps its default value.
  bool added = false;
};

const std::vector<Column<ServoTick>>& tick_columns();
const std::vector<Column<Cut>>& cut_columns();
const std::vector<Column<PatchUse>>& patch_columns();

/// Text for the attribute `labels` of tissue columns: "0 air, 1 enamel, …".
std::string tissue_labels();
/// Text for the attribute `labels` of fault columns: "1 bad_input, 2 stale_patch, …".
std::string fault_labels();

}  // namespace typodont::session
