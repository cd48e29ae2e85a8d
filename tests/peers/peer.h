// What other haptic libraries must implement so that they can run the sliding and drilling tests of bench_models, and
// these tests with their rows.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "engine/base/clock.h"
#include "tests/support/model_tissues.h"

namespace typodont::peers {

inline constexpr double kStiffness = 1000;  // N/m, stiffness of the tissue, as in bench_models

/// Result of a tick.
struct PeerTick {
  dvec3 force{0};     // N, force on the hand
  dvec3 ball{0};      // m, position of the ball's centre, which stays outside the tissue
  double cpu_ns = 0;  // CPU time of the haptic thread
  /// Start and end (m) of the ball's motion that removed tissue in this tick.
  std::optional<std::pair<dvec3, dvec3>> cut{};
};

/// A tissue and a ball of 1.2 mm in a haptic library. A new object has not computed any tick.
class Peer {
 public:
  virtual ~Peer() = default;
  /// Computes one tick of 1 ms. `hand` is the position of the hand in m. If `drills` is true, the ball removes tissue.
  virtual PeerTick tick(const dvec3& hand, bool drills) = 0;
  /// Returns the volume of the tissue in m³.
  virtual double volume() const = 0;
};

/// A library, or a contact model of it, with one value of its setting.
struct PeerModel {
  std::string name, knob;
  // Makes the tissue and the ball, with the ball at the position `hand` (m). `drills` tells which test follows.
  std::function<std::unique_ptr<Peer>(const dvec3& hand, bool drills)> begin;
};

void print_header();
void print_slide(const test::ModelTissue& tissue, const test::Course& course, const PeerModel& model);
void print_drill(const test::ModelTissue& tissue, const PeerModel& model);

/// Returns the default contact model of Typodont.
PeerModel default_model(const test::ModelTissue& tissue, double voxel_mm);

/// Returns the path for the sliding test.
test::Course slide_course(const test::ModelTissue& tissue);

/// Sets `tick.cpu_ns` to the CPU time of `work`, which computes the rest of the tick.
template <class Work>
PeerTick timed_tick(Work&& work) {
  const Nanos start = thread_cpu_time();
  PeerTick tick = work();
  tick.cpu_ns = static_cast<double>(thread_cpu_time() - start);
  return tick;
}

}  // namespace typodont::peers
