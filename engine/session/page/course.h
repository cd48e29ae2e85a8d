// Data for the report, collected by reading all ticks once.
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
  double t0 = 0, t1 = 1;  // s, times of the first and last tick
  std::uint64_t count = 0;
  // Plotted series, in N, mm/s, krpm, mm and mm³.
  Series force, speed, spindle, depth, removed;
  double max_spindle = 0;  // krpm, highest spindle speed in the session
  // For each bin and tissue: number of ticks in which the head touched it.
  std::vector<std::array<std::uint32_t, kTissueCount>> touched;
  struct FaultCount {
    std::uint64_t ticks = 0;
    int times = 0;               // number of separate events; short pauses do not separate them
    double first = 0, last = 0;  // s, times of the first and last tick
  };
  std::vector<FaultCount> faults;  // one entry for each fault in fault_names()
  FaultCount all_faults;           // ticks with any fault; Fault::kHeld, the emergency key, is not counted
  std::vector<float> cpu_us;
  PerTissue removed_total{};  // m³, total removed volume of each tissue
  HandMeasures hand;
};

Course course_of(const SessionReader& session);

/// Score by the rules of the session's scene. A task gets no points, because its shape is not measured.
Score score_of(const SessionReader& session, const ScoreInput& input);
/// Name of the scene; empty if the recording has none.
std::string scene_name_of(const SessionReader& session);
/// The task's title; empty if the scene has no task.
TaskText task_title_of(const SessionReader& session);

}  // namespace typodont::session
