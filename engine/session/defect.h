// Places where a result misses its goal, and the drilling strokes that caused them.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "engine/base/pose.h"

namespace typodont::session {

/// The tool's head at one moment of a stroke, for pictures.
struct HeadMoment {
  double t = 0;  // s, time in the recording
  Pose X_WG;
  double force = 0;  // N, size of the force on the hand
};

/// A pause longer than this ends a stroke, s.
inline constexpr double kStrokePause = 0.75;

/// Cuts, touches or high forces without a pause (kStrokePause) that caused a part of a defect. Times: in the recording.
struct DefectStroke {
  std::uint64_t first = 0, last = 0, worst = 0;  // indices of the first, last and worst tick
  std::uint32_t tool = 0;
  double amount = 0;                      // part of the defect caused by this stroke, in the unit of the score item
  double head_radius = 0, head_half = 0;  // m, radius and half length of the head
  // The next members are read from the ticks. Start and end of the stroke, s.
  double from = 0, to = 0;
  HeadMoment at;                 // the head at the worst tick
  std::vector<HeadMoment> path;  // the head from 1 s before to 0.5 s after the stroke
};

struct Defect {
  std::string item;                   // name of the score item (ScoreItem::name) that lost points
  double amount = 0;                  // size of the defect in unit_of(item)
  dvec3 p_W{0};                       // m, place of the largest deviation
  bool on_tooth = true;               // false: the defect is on a neighbouring tooth or the gum, or is a high force
  bool left = false;                  // true: tissue was left; `strokes` contains the stroke that came nearest to it
  std::vector<DefectStroke> strokes;  // in order of time
};

}  // namespace typodont::session
