// Collects all data that the report needs from a session's ticks in one pass.
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
  double t0 = 0, t1 = 1;  // s
  std::uint64_t count = 0;
  Series force, speed, spindle, depth, removed;  // N, mm/s, krpm, mm, mm³
  double most_spindle = 0;                       // krpm, highest spindle speed
  // number of ticks for each bin and each tissue in contact
  std::vector<std::array<std::uint32_t, kTissueCount>> touched;
  struct FaultCount {
    std::uint64_t ticks = 0;
    double first = 0;
  };
  std::vector<FaultCount> faults;  // one entry for each of fault_names()
  std::vector<float> cpu_us;
  PerTissue removed_total{};  // m³
  HandMeasures hand;
};

/// Reads the session in pieces, so that the memory does not grow with the session's length.
Course course_of(const SessionReader& session);

/// Input of the score: the recorded result; if the session has no result, computed from the ticks.
ScoreInput input_of(const SessionReader& session, const Course& course);
/// Computes the score by the rules of the session's scene.
Score score_of(const SessionReader& session, const ScoreInput& input);
/// Name of the recorded scene; empty if the recording has no scene.
std::string scene_name_of(const SessionReader& session);
/// Title of the scene's task; empty if the task has no title.
TaskText task_title_of(const SessionReader& session);

}  // namespace typodont::session
