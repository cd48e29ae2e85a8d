// The report's data from one reading of the ticks.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "engine/contract/tissue.h"
#include "engine/session/page/plot.h"
#include "engine/session/score.h"
#include "engine/session/session_file.h"
#include "engine/session/task.h"

namespace typodont::session {

struct Course {
  double t0 = 0, t1 = 1;  // s, first and last tick
  std::uint64_t count = 0;
  // N, mm/s, krpm, mm, mm³
  Series force, speed, spindle, depth, removed;
  double most_spindle = 0;  // krpm, highest spindle speed in the session
  // ticks in contact, per bin and tissue
  std::vector<std::array<std::uint32_t, kTissueCount>> touched;
  struct FaultCount {
    std::uint64_t ticks = 0;
    double first = 0;
  };
  std::vector<FaultCount> faults;  // one entry for each fault in fault_names()
  std::vector<float> cpu_us;
  PerTissue removed_total{};  // m³ per tissue
  HandMeasures hand;
};

/// In pieces: memory does not grow with the session.
Course course_of(const SessionReader& session);

/// The hand's measures from `course`, volumes from the result; without those, the initial ones minus what the ticks
/// removed.
ScoreInput input_of(const SessionReader& session, const Course& course);
/// By the rules of the session's scene.
Score score_of(const SessionReader& session, const ScoreInput& input);
/// Empty if the recording has none.
std::string scene_name_of(const SessionReader& session);
/// Empty if the scene has no task.
TaskText task_title_of(const SessionReader& session);

}  // namespace typodont::session
