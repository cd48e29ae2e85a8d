// Passes of "packing" over all spheres (S2 in docs/papers.md): first contact, material there, removal along the path.
// On a GPU a thread per sphere; another module registers Vulkan.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <span>
#include <string>

#include "engine/base/pose.h"

namespace typodont::haptics {

namespace packing {

/// What counts as removed of a partly cut sphere.
enum class Removal {
  // what the tool covers of the uncut sphere (lens, eq. 2 of S2)
  kMended,
  // what it shrinks by (eq. 6 of S2 as printed): about 2r/δ times too much at small overlap δ
  kAsPrinted,
};

/// A cut sphere. `base` is it before the present cut; eq. 6 of S2 gives the present one. Ten doubles for shaders.
struct CutSphere {
  dvec3 base{0};           // m, W, before the present cut
  double base_radius = 0;  // m, radius of the sphere `base`
  // m³ that `base` stands for, with its part of the gaps
  double base_volume = 0;
  // unit vector to the base's centre, from the nearest point of the cutting path
  dvec3 away{0};
  // m, largest overlap with the base; at 2 · base_radius it is gone
  double overlap = 0;
  double tool = 0;  // m, of the ball that cut

  bool operator==(const CutSphere&) const = default;
  double radius() const { return std::max(0.0, base_radius - 0.5 * overlap); }
  dvec3 center() const { return base + 0.5 * overlap * away; }
};
static_assert(sizeof(CutSphere) == 10 * sizeof(double));

}  // namespace packing

/// Moves by `way`. m, W.
struct SweptBall {
  dvec3 from{0}, way{0};
  double radius = 0;
};
/// At rest. m, W.
struct RestingBall {
  dvec3 p{0};
  double radius = 0;
};
/// Cuts from `from` to `to`; spheres near `from` to `near_to`, at or beyond `to`, are examined. m, W.
struct CuttingBall {
  dvec3 from{0}, to{0}, near_to{0};
  double radius = 0;
};

/// Earliest; at equal times the lowest `ball`, then the lowest `sphere`.
struct FirstContact {
  // of the path, 0 to 1; infinity: none
  double t = std::numeric_limits<double>::infinity();
  // of tool and tissue; -1: none
  int ball = -1, sphere = -1;
};
/// m³, overlap or removal.
struct SphereShare {
  std::uint32_t ball, sphere;
  double volume;
};
/// After a tool's sphere.
struct SphereChange {
  std::uint32_t ball, sphere;
  packing::CutSphere after;
};

/// On a GPU, with the CPU's bits; lists unsorted. One thread at a time, after set-up the servo's. False: the GPU's
/// tissue is unknown, load() first.
class SpherePasses {
 public:
  virtual ~SpherePasses() = default;

  /// Returns the name of the GPU, for messages.
  virtual std::string device() const = 0;
  /// of the tissue; most_balls(): of a tool, at most.
  virtual std::size_t spheres() const noexcept = 0;
  virtual std::size_t most_balls() const noexcept = 0;

  /// Whole tissue, spheres() elements.
  virtual bool load(std::span<const packing::CutSphere> tissue, packing::Removal removal) noexcept = 0;

  /// Pass 1: first contact on the spheres' path.
  virtual bool first_contact(std::span<const SweptBall> balls, FirstContact& first) noexcept = 0;
  /// Pass 2: overlapping pairs, with volumes. Until the next call.
  virtual bool overlaps(std::span<const RestingBall> balls, std::span<const SphereShare>& found) noexcept = 0;
  /// Pass 3 without a change: what each tool sphere would remove from each of the tissue, one after the other, nothing
  /// twice.
  virtual bool measure_removal(std::span<const CuttingBall> balls, std::span<const SphereShare>& found) noexcept = 0;
  /// Pass 3: one tool sphere after the other. All changes of each tissue sphere.
  virtual bool remove(std::span<const CuttingBall> balls, std::span<const SphereChange>& found) noexcept = 0;
};

/// At set-up, for so many spheres; null without a fitting GPU. A software GPU only with `any_device`, for tests and
/// measurements.
using SpherePassesMaker = std::function<std::unique_ptr<SpherePasses>(std::size_t spheres, bool any_device)>;

/// Registers, before main(), a function that creates the passes. Declare an object at namespace scope:
///   const SpherePassesRegistration registration{make_vulkan_sphere_passes};
struct SpherePassesRegistration {
  explicit SpherePassesRegistration(SpherePassesMaker maker);
};
/// Null if none is registered.
std::unique_ptr<SpherePasses> make_sphere_passes(std::size_t spheres, bool any_device);

}  // namespace typodont::haptics
