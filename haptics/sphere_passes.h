// The three passes of the model "packing" over all spheres of a tissue (S2: first contact, material at it, removal
// along the way), as a GPU runs them: one thread a sphere. This module knows no Vulkan; whoever does registers an
// implementation.
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

/// How the volume of a partly cut sphere is counted.
enum class Removal {
  kMended,     // what the tool covers of the sphere as it was: the lens of eq. 2
  kAsPrinted,  // eq. 6 to the letter, the shrunk sphere's own volume: about 2r/δ times too much for a small overlap δ
};

/// A sphere as cuts left it. `base` is the sphere before the cut that is under way: as packed, or as an earlier cut
/// from another side left it. Where the sphere is now follows from it by eq. 6. Shaders read it as ten doubles.
struct CutSphere {
  dvec3 base{0};           // m, W
  double base_radius = 0;  // m
  double base_volume = 0;  // m³ that counts as its volume
  dvec3 away{0};           // unit, from the tool's path to the base
  double overlap = 0;      // m, the deepest so far; at 2 · base_radius nothing is left
  double tool = 0;         // m, radius of the ball that cut it

  bool operator==(const CutSphere&) const = default;
  double radius() const { return std::max(0.0, base_radius - 0.5 * overlap); }
  dvec3 center() const { return base + 0.5 * overlap * away; }
};
static_assert(sizeof(CutSphere) == 10 * sizeof(double));

}  // namespace packing

/// One sphere of a tool that moves by `way`. W, m.
struct SweptBall {
  dvec3 from{0}, way{0};
  double radius = 0;
};
/// One at rest.
struct RestingBall {
  dvec3 p{0};
  double radius = 0;
};
/// One that cuts from `from` to `to`. Only spheres near the way from `from` to `near_to` are looked at.
struct CuttingBall {
  dvec3 from{0}, to{0}, near_to{0};
  double radius = 0;
};

/// Of several contacts at once: the least `ball`, then the least `sphere`.
struct FirstContact {
  double t = std::numeric_limits<double>::infinity();  // 0 to 1 of the way
  int ball = -1, sphere = -1;                          // -1: no contact
};
/// A ball and a sphere of the tissue, and the volume that they share or that the ball takes, m³.
struct SphereShare {
  std::uint32_t ball, sphere;
  double volume;
};
/// A sphere of the tissue after that ball has cut it.
struct SphereChange {
  std::uint32_t ball, sphere;
  packing::CutSphere after;
};

/// One thread at a time, after set-up the servo's. All results have the same bits as the processor's. The lists come in
/// no order. A function that returns false has failed; the tissue on the GPU is then no longer known, and nothing more
/// may be asked before the next load().
class SpherePasses {
 public:
  virtual ~SpherePasses() = default;

  /// What they run on, for people.
  virtual std::string device() const = 0;
  /// How many spheres it was made for, and the most balls of a tool.
  virtual std::size_t spheres() const noexcept = 0;
  virtual std::size_t most_balls() const noexcept = 0;

  /// Puts the whole tissue onto the GPU: as many spheres as it was made for.
  virtual bool load(std::span<const packing::CutSphere> tissue, packing::Removal removal) noexcept = 0;

  /// Pass 1.
  virtual bool first_contact(std::span<const SweptBall> balls, FirstContact& first) noexcept = 0;
  /// Pass 2: all pairs that overlap, with the volume of their lens. The list is valid until the next call.
  virtual bool overlaps(std::span<const RestingBall> balls, std::span<const SphereShare>& found) noexcept = 0;
  /// Pass 3, only measured: what each ball by itself would take of each sphere.
  virtual bool measure_removal(std::span<const CuttingBall> balls, std::span<const SphereShare>& found) noexcept = 0;
  /// Pass 3: one ball after the other shrinks the spheres on its way. All changes of a sphere are listed.
  virtual bool remove(std::span<const CuttingBall> balls, std::span<const SphereChange>& found) noexcept = 0;
};

/// Set-up. Makes the passes for that many spheres. Null where there is no GPU that can run them. A processor that plays
/// a GPU is never chosen, except where `any_device` asks for it: for tests and measurements.
using SpherePassesMaker = std::function<std::unique_ptr<SpherePasses>(std::size_t spheres, bool any_device)>;

/// Before main(), at namespace scope: const SpherePassesRegistration registration{make_vulkan_sphere_passes};
struct SpherePassesRegistration {
  explicit SpherePassesRegistration(SpherePassesMaker maker);
};
/// By the registered maker; null where there is none.
std::unique_ptr<SpherePasses> make_sphere_passes(std::size_t spheres, bool any_device);

}  // namespace typodont::haptics
