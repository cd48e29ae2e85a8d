// The data of a recorded session except the servo's messages: plain data for writer and reader.
#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "engine/base/clock.h"
#include "engine/contract/contact.h"
#include "engine/contract/tissue.h"

namespace typodont::session {

/// A file from which the scene was built. A replay uses this entry to detect later changes of the file.
struct SourceFile {
  std::string path;  // path of the file that the scene names
  std::uint64_t bytes = 0;
  std::string hash;  // "fnv1a64:" and 16 hexadecimal digits, see hash.h
  bool operator==(const SourceFile&) const = default;
};

/// Samples that are recorded in addition to the ticks, e.g. the head's pose or the sound's parameters.
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

/// Data known before the first tick: all data besides the ticks that a replay needs.
struct SessionHeader {
  std::string scene_json;                                    // the complete scene as JSON, with all overrides
  std::string rig_json;                                      // the complete rig as JSON; empty if there is no rig
  std::vector<SourceFile> files;                             // the files from which scene and rig were built
  std::string hand;                                          // the device's address, e.g. "script:hand.csv"
  std::string trainee;                                       // free text; empty: unknown
  std::vector<std::pair<std::string, std::uint64_t>> seeds;  // seeds of all random generators, by name
  std::vector<std::string> tools;         // names or inline JSON of the tools; Cut::tool is an index into this list
  std::vector<StreamSpec> streams;        // additional recorded streams
  std::string model = "offset";           // name of the contact model; its parameters are in the scene
  std::uint32_t servo_laws = kServoLaws;  // version of the force laws (contract/contact.h)
  double servo_rate = 1000;               // Hz
  double position_step = 0;  // m, smallest step of the hand's device (one encoder count); a replay needs it
  bool gives_torque = true;  // true if the hand's device can apply torque; a replay needs it
  // Hz, highest frequency of the spindle's vibration that the hand's device rendered; a replay needs it
  double vibration_band = 0;
  double voxel = 0;            // m
  PerTissue volumes_before{};  // m³, volume of each tissue at the start
  std::string date;            // ISO 8601, UTC; empty: omitted, as in deterministic runs
  std::string program_version = TYPODONT_VERSION;
  std::string compiler = compiler_of_this_build();
  static std::string compiler_of_this_build();
};

/// The present time, for example "2025-03-14T09:26:53Z".
std::string iso_date_now();

enum class EventKind : std::uint8_t { kNote, kTool, kView, kFault, kTask, kUndo, kRedo, kScore, kPiece };
inline constexpr int kEventKindCount = 9;
std::string_view name_of(EventKind kind) noexcept;

/// A fault and its name in files.
struct FaultName {
  Fault fault;
  std::string name;  // "bad_input"
};
const std::vector<FaultName>& fault_names();
/// Name of a fault bit, for example "stale_patch"; "unknown" for other values.
std::string_view fault_name(std::uint32_t bit) noexcept;

/// An event: a change of tool, a change of view, the beginning of a fault, an instructor's note.
struct SessionEvent {
  Nanos t = 0;  // ns, time since the session's start
  EventKind kind = EventKind::kNote;
  std::string text;  // UTF-8; free text, or JSON if the kind has parameters
  bool operator==(const SessionEvent&) const = default;
};

/// Counts of data that did not reach the file. All counts are zero in a good session.
struct Lost {
  // ticks that were lost because the ring to the recorder was full (slow disk or machine)
  std::uint64_t ticks_ring = 0;
  std::uint64_t cuts_ring = 0;
  std::uint64_t ticks_disk = 0;  // ticks that reached the recorder but were lost because the disk was full or failed
  std::uint64_t cuts_disk = 0;
  std::uint64_t other_disk = 0;     // patch uses, events and stream samples that the disk lost
  std::uint64_t other_ring = 0;     // patch uses, events and stream samples that a ring lost
  std::uint64_t pictures_disk = 0;  // pictures of the result that the disk lost
  bool operator==(const Lost&) const = default;
  bool any() const { return *this != Lost{}; }
};
/// The counts as text, for example "12 ticks, 1 pictures"; empty: no loss.
std::string in_words(const Lost& lost);

/// An interval in which ticks or cuts are missing although later ones exist. Cause: the disk was full, or the
/// recorder was late.
struct Gap {
  Nanos from = 0, to = 0;             // times of the last row before the gap and of the first row after it
  std::uint64_t after_tick = 0;       // index of the last tick before the gap
  std::uint64_t ticks = 0, cuts = 0;  // number of missing rows
  bool operator==(const Gap&) const = default;
};
/// The gaps as text: "12.300 s to 18.304 s (6004 ticks, 1203 cuts)". If there are many gaps, lists the first three
/// and the number of the other gaps.
std::string in_words(const std::vector<Gap>& gaps);

/// A picture stored in the session for its report.
struct SessionPicture {
  // for example "before", "after", "during_2"; the report uses the name to sort pictures and to choose titles
  std::string name;
  std::string title;  // title to show; empty: derived from the name
  std::vector<std::uint8_t> png;
  bool operator==(const SessionPicture&) const = default;
};

/// Data that is known only at the end of the session.
struct SessionResult {
  PerTissue volumes_after{};  // m³
  bool has_volumes = false;
  PerTissue volumes_ideal{};  // m³ of the ideal result; valid if has_ideal
  bool has_ideal = false;
  double min_pulp_distance = -1;  // m, distance between the cut surface and the pulp; negative: not measured
  std::uint64_t field_hash = 0;   // hash of the final tissue; 0: not computed
  std::vector<SessionPicture> pictures;
};

}  // namespace typodont::session
