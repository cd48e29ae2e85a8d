// The three passes of the model "packing" over all spheres of a tissue (paper S2 in docs/papers.md): first contact,
// material at the contact, removal along the path. A GPU runs each pass with one thread per sphere. This module does
// not use Vulkan; another module, which does, registers an implementation.
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

/// Definition of the volume removed from a partly cut sphere.
enum class Removal {
  kMended,     // volume of the uncut sphere that the tool covers: the lens of eq. 2
  kAsPrinted,  // volume lost by the shrunk sphere, eq. 6 as printed: about 2r/δ times too large for a small overlap δ
};

/// A sphere after cuts. `base` is the sphere before the present cut: as packed, or as an earlier cut from another side
/// left it. Eq. 6 gives the present sphere from it. Shaders read this struct as ten doubles.
struct CutSphere {
  dvec3 base{0};           // m, W
  double base_radius = 0;  // m
  double base_volume = 0;  // m³, volume of the base
  dvec3 away{0};           // unit, direction from the tool's path to the base
  double overlap = 0;      // m, deepest overlap so far; at 2 · base_radius the sphere is removed completely
  double tool = 0;         // m, radius of the ball that cut the sphere

  bool operator==(const CutSphere&) const = default;
  double radius() const { return std::max(0.0, base_radius - 0.5 * overlap); }
  dvec3 center() const { return base + 0.5 * overlap * away; }
};
static_assert(sizeof(CutSphere) == 10 * sizeof(double));

}  // namespace packing

/// A sphere of the tool that moves by `way`. W, m.
struct SweptBall {
  dvec3 from{0}, way{0};
  double radius = 0;
};
/// A sphere of the tool at rest. W, m.
struct RestingBall {
  dvec3 p{0};
  double radius = 0;
};
/// A sphere of the tool that cuts on its path from `from` to `to`. Only the tissue near the path from `from` to
/// `near_to` is examined. W, m.
struct CuttingBall {
  dvec3 from{0}, to{0}, near_to{0};
  double radius = 0;
};

/// The first contact of one of the tool's spheres. Of simultaneous contacts: the lowest index `ball`, then the lowest
/// index `sphere`.
struct FirstContact {
  double t = std::numeric_limits<double>::infinity();  // fraction of the path, 0 to 1
  int ball = -1, sphere = -1;                          // -1: no contact
};
/// A sphere of the tool and a sphere of the tissue, with the volume of their overlap or of the removal, m³.
struct SphereShare {
  std::uint32_t ball, sphere;
  double volume;
};
/// A sphere of the tissue after a sphere of the tool has cut it.
struct SphereChange {
  std::uint32_t ball, sphere;
  packing::CutSphere after;
};

/// One thread at a time: after set-up, the servo's. All results have the same bits as on the processor. The lists
/// that they return are not sorted. If a function returns false, the state of the tissue on the GPU is unknown, and
/// load() must be called before any other function.
class SpherePasses {
 public:
  virtual ~SpherePasses() = default;

  /// Name of the device, for messages.
  virtual std::string device() const = 0;
  /// Number of spheres in the tissue, and largest number of spheres in a tool.
  virtual std::size_t spheres() const noexcept = 0;
  virtual std::size_t most_balls() const noexcept = 0;

  /// Copies the whole tissue to the GPU: spheres() spheres.
  virtual bool load(std::span<const packing::CutSphere> tissue, packing::Removal removal) noexcept = 0;

  /// Pass 1: finds the first contact on the tool's path.
  virtual bool first_contact(std::span<const SweptBall> balls, FirstContact& first) noexcept = 0;
  /// Pass 2: all pairs that overlap, with the volume of their lens. The list is valid until the next call.
  virtual bool overlaps(std::span<const RestingBall> balls, std::span<const SphereShare>& found) noexcept = 0;
  /// Pass 3 without removal: measures what each sphere of the tool would remove from each sphere of the tissue, after
  /// the spheres of the tool before it.
  virtual bool measure_removal(std::span<const CuttingBall> balls, std::span<const SphereShare>& found) noexcept = 0;
  /// Pass 3: the tool's spheres, one after another, shrink the spheres on their path. Lists all changes of each sphere.
  virtual bool remove(std::span<const CuttingBall> balls, std::span<const SphereChange>& found) noexcept = 0;
};

/// Makes the passes for this number of spheres, at set-up. Returns null if no GPU can run them. A software GPU is used
/// only if `any_device` is true, for tests and measurements.
using SpherePassesMaker = std::function<std::unique_ptr<SpherePasses>(std::size_t spheres, bool any_device)>;

/// Registers a maker before main(). Declare it at namespace scope:
///   const SpherePassesRegistration registration{make_vulkan_sphere_passes};
struct SpherePassesRegistration {
  explicit SpherePassesRegistration(SpherePassesMaker maker);
};
/// Calls the registered maker; null if there is none.
std::unique_ptr<SpherePasses> make_sphere_passes(std::size_t spheres, bool any_device);

}  // namespace typodont::haptics
