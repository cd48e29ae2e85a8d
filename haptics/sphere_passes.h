// The three passes of the contact model "packing" over all spheres (paper S2, see docs/papers.md): first contact,
// overlap, and removal along the path. On a GPU, each sphere has a thread; another module registers the Vulkan version.
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

/// Which volume of a partly cut sphere counts as removed.
enum class Removal {
  // The intersection of the tool with the uncut sphere (lens, eq. 2 of paper S2).
  kMended,
  // The sphere's loss of volume by eq. 6 of paper S2 as printed; at a small overlap δ, 2 radius/δ times too large.
  kAsPrinted,
};

/// A cut sphere: `base` is the sphere before the current cut, from which eq. 6 of paper S2 computes the current sphere.
/// Twelve doubles, as in the shaders.
struct CutSphere {
  dvec3 base{0};           // m, frame W, centre before the current cut
  double base_radius = 0;  // m, radius of the sphere `base`
  double volume = 0;       // m³, remaining volume, including the sphere's part of the gaps between spheres
  // Unit vector from the nearest point of the cutting path to the base's centre.
  dvec3 away{0};
  // Largest overlap with the base, m; at 2 · base_radius the sphere is gone.
  double overlap = 0;
  double tool = 0;          // m, radius of the tool sphere that cut
  double whole_radius = 0;  // m, radius before all cuts
  double whole_volume = 0;  // m³, `volume` before all cuts

  bool operator==(const CutSphere&) const = default;
  double radius() const { return std::max(0.0, base_radius - 0.5 * overlap); }
  dvec3 center() const { return base + 0.5 * overlap * away; }
};
static_assert(sizeof(CutSphere) == 12 * sizeof(double));

}  // namespace packing

/// Sphere of the tool that moves by the vector `motion`; lengths in m, frame W.
struct SweptBall {
  dvec3 from{0}, motion{0};
  double radius = 0;
};
/// Sphere of the tool at rest; lengths in m, frame W.
struct RestingBall {
  dvec3 p{0};
  double radius = 0;
};
/// Sphere of the tool that cuts from `from` to `to` (m, frame W). Tissue spheres near the path from `from` to `near_to`
/// (at or beyond `to`) are examined.
struct CuttingBall {
  dvec3 from{0}, to{0}, near_to{0};
  double radius = 0;
  double curve = 0;  // m, packing::ToolSpheres::curve
};

/// Earliest contact; at equal times, the one with the lowest `ball`, then the lowest `sphere`.
struct FirstContact {
  // Fraction 0..1 of the path; infinity: no contact.
  double t = std::numeric_limits<double>::infinity();
  // Indices of the tool sphere and the tissue sphere; -1: no contact.
  int ball = -1, sphere = -1;
};
/// Volume of a sphere pair, m³: overlap, or removed volume.
struct SphereShare {
  std::uint32_t ball, sphere;
  double volume;
};
/// State of a tissue sphere after a tool sphere has cut it.
struct SphereChange {
  std::uint32_t ball, sphere;
  packing::CutSphere after;
};

/// The passes on a GPU, with bit-identical results to those of the CPU; the lists of results are not sorted. Used by
/// one thread at a time. If a function returns false, the tissue on the GPU is unknown: call load().
class SpherePasses {
 public:
  virtual ~SpherePasses() = default;

  /// Returns the name of the GPU, for messages.
  virtual std::string device() const = 0;
  /// spheres(): number of spheres of the tissue. max_balls(): largest number of spheres of a tool.
  virtual std::size_t spheres() const noexcept = 0;
  virtual std::size_t max_balls() const noexcept = 0;

  /// Loads the whole tissue, which has spheres() spheres. Returns false if this fails.
  virtual bool load(std::span<const packing::CutSphere> tissue, packing::Removal removal) noexcept = 0;

  /// Pass 1: finds the first contact of moving tool spheres.
  virtual bool first_contact(std::span<const SweptBall> balls, FirstContact& first) noexcept = 0;
  /// Pass 2: finds overlapping pairs with their volumes. The result is valid until the next call.
  virtual bool overlaps(std::span<const RestingBall> balls, std::span<const SphereShare>& found) noexcept = 0;
  /// Pass 3 without changing the tissue: the volume that each tool sphere, in turn, would remove from each tissue
  /// sphere. No volume is counted twice.
  virtual bool measure_removal(std::span<const CuttingBall> balls, std::span<const SphereShare>& found) noexcept = 0;
  /// Pass 3: removes tissue, one tool sphere after another. `found`: receives all changes of tissue spheres.
  virtual bool remove(std::span<const CuttingBall> balls, std::span<const SphereChange>& found) noexcept = 0;
};

/// Creates the passes for a number of spheres, at set-up; null if no GPU is suitable. `any_device`: also accepts a
/// software GPU, for tests and measurements.
using SpherePassesMaker = std::function<std::unique_ptr<SpherePasses>(std::size_t spheres, bool any_device)>;

/// Registers, before main(), a function that creates the passes. Declare an object at namespace scope:
///   const SpherePassesRegistration registration{make_vulkan_sphere_passes};
struct SpherePassesRegistration {
  explicit SpherePassesRegistration(SpherePassesMaker maker);
};
/// Returns null if no maker is registered.
std::unique_ptr<SpherePasses> make_sphere_passes(std::size_t spheres, bool any_device);

}  // namespace typodont::haptics
