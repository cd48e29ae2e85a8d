// Collects the data for the report from a session's ticks. All ticks are read once.
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
  double t0 = 0, t1 = 1;  // s, times of the first and the last tick
  std::uint64_t count = 0;
  // force in N, speed in mm/s, spindle speed in krpm, depth in mm, removed volume in mm³
  Series force, speed, spindle, depth, removed;
  double most_spindle = 0;  // krpm, highest spindle speed in the session
  // for each bin and each tissue: number of ticks in which the head touched this tissue
  std::vector<std::array<std::uint32_t, kTissueCount>> touched;
  struct FaultCount {
    std::uint64_t ticks = 0;
    double first = 0;
  };
  std::vector<FaultCount> faults;  // one entry for each fault in fault_names()
  std::vector<float> cpu_us;
  PerTissue removed_total{};  // for each tissue: m³, volume that was removed in the session
  HandMeasures hand;
};

/// Reads the ticks of a session in pieces, so that the memory does not grow with the session's length.
Course course_of(const SessionReader& session);

/// Returns the input of the score: the hand's measures from `course`, and the tissue volumes from the session's result.
/// If the session has no final volumes, they are computed: the initial volumes minus the volumes that the ticks
/// removed.
ScoreInput input_of(const SessionReader& session, const Course& course);
/// Computes the score with the rules of the session's scene.
Score score_of(const SessionReader& session, const ScoreInput& input);
/// Returns the name of the scene in the recording; empty if the recording has none.
std::string scene_name_of(const SessionReader& session);
/// Returns the title of the task in the session's scene; empty if there is none.
TaskText task_title_of(const SessionReader& session);

}  // namespace typodont::session
