// A finding of `typodont doctor`, for the terminal and for the window's page "Check this computer".
#pragma once

#include <array>
#include <string>
#include <string_view>
#include <utility>

namespace typodont {

enum class PartState { kOk, kDegraded, kMissing };
inline constexpr std::array<std::string_view, 3> kPartStateNames{"ok", "degraded", "missing"};

constexpr std::string_view name_of(PartState state) {
  return kPartStateNames[static_cast<std::size_t>(state)];
}
/// The state of this name. An unknown name counts as missing.
constexpr PartState part_state_named(std::string_view name) {
  for (const PartState state : {PartState::kOk, PartState::kDegraded})
    if (name_of(state) == name) return state;
  return PartState::kMissing;
}

struct DoctorFinding {
  DoctorFinding(std::string id_text, std::string name_text) : id(std::move(id_text)), name(std::move(name_text)) {}
  std::string id;    // name for other programs, for example "vulkan"
  std::string name;  // name of the part in the report
  PartState state = PartState::kOk;
  std::string found;      // what the check has found on this machine
  std::string without;    // what does not work without the part; empty: the part is not missing
  std::string mend;       // command or manual step that adds the part
  bool required = false;  // true: without the part, the program cannot run, not even offscreen

  /// Green, yellow and red. Red is only a missing part that the program requires.
  enum class Severity { kGood, kWarning, kFailure };
  Severity severity() const {
    if (state == PartState::kOk) return Severity::kGood;
    return required && state == PartState::kMissing ? Severity::kFailure : Severity::kWarning;
  }
};

}  // namespace typodont
