// What a recorded session consists of, besides the servo's own messages: plain data, shared by writer and reader.
#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "engine/base/clock.h"
#include "engine/contract/contact.h"
#include "engine/contract/tissue.h"

namespace typodont::session {

/// A file the scene was made from, so that a replay can tell that it has changed since.
struct SourceFile {
  std::string path;  // as the scene named it, resolved
  std::uint64_t bytes = 0;
  std::string hash;  // "fnv1a64:" and 16 hexadecimal digits, see hash.h
  bool operator==(const SourceFile&) const = default;
};

/// Regular samples beside the ticks, e.g. the head's pose or the sound's parameters.
struct StreamSpec {
  struct Column {
    std::string name;  // "head_x_m": letters, digits and _
    std::string unit;  // "m"
    bool operator==(const Column&) const = default;
  };
  std::string name;  // "head"
  std::vector<Column> columns;
  bool operator==(const StreamSpec&) const = default;
};

/// Known before the first tick. Everything a replay needs besides the ticks.
struct SessionHeader {
  std::string scene_json;                                    // the scene in full, with every override
  std::string rig_json;                                      // the rig in full; empty without one
  std::vector<SourceFile> files;                             // what scene and rig were made from
  std::string hand;                                          // the device's address, e.g. "script:hand.csv"
  std::string trainee;                                       // free text; empty: not named
  std::vector<std::pair<std::string, std::uint64_t>> seeds;  // of every generator, by name
  std::vector<std::string> tools;                            // Cut::tool counts into these; names or inline JSON
  std::vector<StreamSpec> streams;                           // what else is recorded
  std::string model = "offset";           // the contact model, by name; its parameters are in the scene
  std::uint32_t servo_laws = kServoLaws;  // version of the force laws (contract/contact.h)
  double servo_rate = 1000;               // Hz
  double position_step = 0;  // m, the least that the hand's device moved by, a count of its encoders; a replay needs it
  bool gives_torque = true;  // whether the hand's device resisted turns; a replay needs it
  double vibration_band = 0;   // Hz up to which the hand rendered the spindle's vibration; a replay needs it
  double voxel = 0;            // m
  PerTissue volumes_before{};  // m³ of each tissue at the start
  std::string date;            // ISO 8601, UTC; empty: left out (deterministic runs)
  std::string program_version = TYPODONT_VERSION;
  std::string compiler = compiler_of_this_build();
  static std::string compiler_of_this_build();
};

/// "2025-03-14T09:26:53Z".
std::string iso_date_now();

enum class EventKind : std::uint8_t { kNote, kTool, kView, kFault, kTask, kUndo, kRedo, kScore, kPiece };
inline constexpr int kEventKindCount = 9;
std::string_view name_of(EventKind kind) noexcept;

/// Every fault and what it is called in files.
struct FaultName {
  Fault fault;
  std::string name;  // "bad_input"
};
const std::vector<FaultName>& fault_names();
/// "stale_patch" of its bit; "unknown" for other numbers.
std::string_view fault_name(std::uint32_t bit) noexcept;

/// Something that happened once: a tool was taken up, the view moved, a fault began, an instructor's note.
struct SessionEvent {
  Nanos t = 0;  // since the session's start
  EventKind kind = EventKind::kNote;
  std::string text;  // UTF-8; free, or JSON where the kind has parameters
  bool operator==(const SessionEvent&) const = default;
};

/// What did not reach the file. All zero in a good session.
struct Lost {
  std::uint64_t ticks_ring = 0;  // found no room in the ring to the recorder (slow disk, or a starved machine)
  std::uint64_t cuts_ring = 0;
  std::uint64_t ticks_disk = 0;  // reached the recorder, but the disk was full or failing
  std::uint64_t cuts_disk = 0;
  std::uint64_t other_disk = 0;     // patch uses, events, stream samples
  std::uint64_t other_ring = 0;     // the same
  std::uint64_t pictures_disk = 0;  // of the result
  bool operator==(const Lost&) const = default;
  bool any() const { return *this != Lost{}; }
};
/// "12 ticks, 1 pictures"; empty: nothing.
std::string in_words(const Lost& lost);

/// A place where ticks or cuts are missing although later ones are there: the disk was full, or the recorder was late.
struct Gap {
  Nanos from = 0, to = 0;             // of the last row before and the first one after
  std::uint64_t after_tick = 0;       // index of the last tick before
  std::uint64_t ticks = 0, cuts = 0;  // how many are missing
  bool operator==(const Gap&) const = default;
};
/// "12.300 s to 18.304 s (6004 ticks, 1203 cuts)"; of many gaps the first three, and how many more.
std::string in_words(const std::vector<Gap>& gaps);

/// A picture kept inside the session for its report.
struct SessionPicture {
  std::string name;   // "before", "after", "during_2": the report orders and titles them by name
  std::string title;  // for people; empty: derived from the name
  std::vector<std::uint8_t> png;
  bool operator==(const SessionPicture&) const = default;
};

/// Known at the end.
struct SessionResult {
  PerTissue volumes_after{};  // m³
  bool has_volumes = false;
  PerTissue volumes_ideal{};  // m³ of the ideal result; has_ideal when the scene names one
  bool has_ideal = false;
  double min_pulp_distance = -1;  // m between the cut surface and the pulp; negative: not measured
  std::uint64_t field_hash = 0;   // of the tissue at the end; 0: not taken
  std::vector<SessionPicture> pictures;
};

}  // namespace typodont::session
