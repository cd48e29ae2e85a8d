// Everything the report needs to know of a session's ticks, in one pass over them.
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
  Series force, speed, spindle, depth, removed;                  // N, mm/s, krpm, mm, mm³
  double most_spindle = 0;                                       // krpm
  std::vector<std::array<std::uint32_t, kTissueCount>> touched;  // ticks per bin and tissue in contact
  struct FaultCount {
    std::uint64_t ticks = 0;
    double first = 0;
  };
  std::vector<FaultCount> faults;  // parallel to fault_names()
  std::vector<float> cpu_us;
  PerTissue removed_total{};  // m³
  HandMeasures hand;
};

/// Reads it piece by piece: memory does not grow with the session.
Course course_of(const SessionReader& session);

/// What is judged: of the recorded result, or of the ticks where there is none.
ScoreInput input_of(const SessionReader& session, const Course& course);
/// By the rules of the session's own scene.
Score score_of(const SessionReader& session, const ScoreInput& input);
/// Empty where the recording has no scene.
std::string scene_name_of(const SessionReader& session);
/// Of the scene's task; empty where it has none.
TaskText task_title_of(const SessionReader& session);

}  // namespace typodont::session
