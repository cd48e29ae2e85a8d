// The data of a recorded session except the servo's messages. Both the writer and the reader use these types.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "engine/base/clock.h"
#include "engine/contract/contact.h"
#include "engine/contract/force_law.h"
#include "engine/contract/tissue.h"

namespace typodont::session {

/// A file from which the scene was built. A replay reads only a file with the same hash.
struct SourceFile {
  std::string path;  // path relative to assets/; for a file outside of assets/, only its name
  std::uint64_t bytes = 0;
  std::string hash;  // "sha256:" and 64 hexadecimal digits
  bool operator==(const SourceFile&) const = default;
};

/// A stream of samples that is recorded in addition to the ticks, for example the head's pose or the sound's
/// parameters.
struct StreamSpec {
  struct Column {
    std::string name;  // name of the column, for example "head_x_m"; it consists of letters, digits and _
    std::string unit;  // unit of the column's numbers, for example "m"
    bool operator==(const Column&) const = default;
  };
  std::string name;  // name of the stream, for example "head"
  std::vector<Column> columns;
  bool operator==(const StreamSpec&) const = default;
};

/// How early a trainee is warned before the error of an item of the score: 0 (not before the error) to 1. An item that
/// is not listed gives no warning.
using WarningLevels = std::map<std::string, double>;

/// Data that is known before the first tick. A replay needs nothing else besides the ticks.
struct SessionHeader {
  std::string scene_json;         // the complete scene as JSON, with all overrides
  std::string rig_json;           // complete rig as JSON; empty if there is none
  std::vector<SourceFile> files;  // source files of the scene and the rig
  std::string hand;               // address of the hand's device, for example "script:hand.csv"
  std::string trainee;            // free text that names the trainee; empty if unknown
  WarningLevels warnings;         // levels of the warnings over the picture; empty: none
  std::vector<std::pair<std::string, std::uint64_t>> seeds;  // names and seeds of all random number generators
  std::vector<std::string> tools;       // name or JSON text of each tool; Cut::tool is an index into this list
  std::vector<StreamSpec> streams;      // streams that are recorded in addition to the ticks
  std::string model = "offset";         // contact model's name; its parameters are in the scene
  std::uint64_t force_law = kForceLaw;  // version of the ticks' force law; 0: not stated
  double servo_rate = 1000;             // Hz, rate of the servo
  double position_step = 0;             // m, smallest step of the hand's device (one encoder count); a replay needs it
  bool gives_torque = true;             // true: the device can apply torque; needed by a replay
  // Highest frequency, in Hz, of the spindle vibration that the hand's device rendered. A replay needs this value.
  double vibration_band = 0;
  double voxel = 0;            // m, edge of a voxel
  PerTissue volumes_before{};  // m³, volume of each tissue at the start
  std::string date;            // date and time in ISO 8601, UTC; empty if omitted, as in deterministic runs
  std::string program_version = TYPODONT_VERSION;
  std::string compiler = compiler_of_this_build();
  static std::string compiler_of_this_build();
};

/// The current date and time, for example "2025-03-14T09:26:53Z".
std::string iso_date_now();

/// A date that a file states in UTC (ISO 8601), converted to the time zone of this machine.
struct LocalTime {
  std::string text;  // "2025-03-14 10:26"
  std::string zone;  // difference from UTC at that time: "UTC+01:00"
};
/// Empty if the text has not the form of iso_date_now().
std::optional<LocalTime> local_time(const std::string& iso);

enum class EventKind : std::uint8_t { kNote, kTool, kView, kFault, kTask, kUndo, kRedo, kScore, kPiece };
inline constexpr int kEventKindCount = 9;
std::string_view name_of(EventKind kind) noexcept;

/// A fault bit and its name in files.
struct FaultName {
  Fault fault;
  std::string name;  // name of the fault in files, for example "bad_input"
};
const std::vector<FaultName>& fault_names();
/// The name of a fault bit, for example "stale_patch", or "unknown" for other values.
std::string_view fault_name(std::uint32_t bit) noexcept;

/// An event of a session: a change of tool, a change of view, the beginning of a fault, or an instructor's note.
struct SessionEvent {
  Nanos t = 0;  // ns, time since the session's start
  EventKind kind = EventKind::kNote;
  std::string text;  // UTF-8; free text, or JSON for events with parameters
  bool operator==(const SessionEvent&) const = default;
};

/// Numbers of items that did not reach the file. All are zero if nothing was lost.
struct Lost {
  // number of ticks lost because the queue to the recorder was full (slow disk or machine)
  std::uint64_t ticks_ring = 0;
  std::uint64_t cuts_ring = 0;
  // number of ticks that reached the recorder but were lost because the disk was full or failed
  std::uint64_t ticks_disk = 0;
  std::uint64_t cuts_disk = 0;
  // Number of other records lost because the disk was full or failed: changes of the servo's tissue copy, events,
  // stream samples.
  std::uint64_t other_disk = 0;
  std::uint64_t other_ring = 0;     // number of records other than ticks and cuts, lost because a queue was full
  std::uint64_t pictures_disk = 0;  // number of pictures of the result lost because the disk was full or failed
  bool operator==(const Lost&) const = default;
  bool any() const { return *this != Lost{}; }
};
/// The numbers as text, for example "12 ticks, 1 pictures"; empty if nothing was lost.
std::string in_words(const Lost& lost);

/// A gap in a recording: an interval in which ticks or cuts are missing, although later ones exist. The cause is a full
/// disk or a late recorder.
struct Gap {
  Nanos from = 0, to = 0;             // ns, times of the last row before the gap and of the first row after it
  std::uint64_t after_tick = 0;       // index of the last tick before the gap
  std::uint64_t ticks = 0, cuts = 0;  // number of missing ticks and cuts
  bool operator==(const Gap&) const = default;
};
/// The gaps as text: "12.300 s to 18.304 s (6004 ticks, 1203 cuts)". If there are many gaps, the text lists the first
/// three gaps and states the number of other gaps.
std::string in_words(const std::vector<Gap>& gaps);

/// A picture stored in the session for its report.
struct SessionPicture {
  // Name such as "before", "after" or "during_2". The report uses it to sort the pictures and to choose their titles.
  std::string name;
  std::string title;  // title for the report; if empty, derived from the name
  std::vector<std::uint8_t> png;
  bool operator==(const SessionPicture&) const = default;
};

/// Data that is known only at the session's end.
struct SessionResult {
  PerTissue volumes_after{};  // m³ of each tissue at the end
  bool has_volumes = false;
  PerTissue volumes_ideal{};  // m³ of each tissue in the target shape; valid only if has_ideal
  bool has_ideal = false;
  double min_pulp_distance = -1;  // m, smallest distance of the cut surface from the pulp; negative if not measured
  std::uint64_t field_hash = 0;   // hash of the final tissue; 0 if not computed
  std::vector<SessionPicture> pictures;
};

}  // namespace typodont::session
