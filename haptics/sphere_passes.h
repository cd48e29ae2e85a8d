// The three passes of the contact model "packing" over all spheres of a tissue (paper S2 in docs/papers.md): first
// contact, material at the contact, and removal along the path. A GPU runs each pass with one thread per tissue sphere.
// This module does not use Vulkan; another module registers an implementation with Vulkan.
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

/// Defines which volume counts as removed when a sphere is partly cut.
enum class Removal {
  // volume of the part of the uncut sphere that the tool covers (the lens in eq. 2 of paper S2, docs/papers.md)
  kMended,
  // volume that the sphere loses when it shrinks (eq. 6 of paper S2 as printed); for a small overlap δ of a sphere of
  // radius r it is about 2r/δ times too large
  kAsPrinted,
};

/// State of a sphere that was cut. `base` is the sphere before the present cut: as packed, or after an earlier cut from
/// another side. Eq. 6 of paper S2 computes the present sphere from the base. Shaders read this struct as ten doubles.
struct CutSphere {
  dvec3 base{0};           // m, centre of the sphere before the present cut, workbench frame W
  double base_radius = 0;  // m, radius of the sphere `base`
  // m³, volume of tissue that the sphere `base` represents: its own volume and its part of the gaps around it
  double base_volume = 0;
  // unit vector to the centre of the base sphere, from the nearest point of the path on which the tool cut it
  dvec3 away{0};
  // m, largest overlap of the tool with the base sphere so far; at 2 · base_radius the sphere is removed completely
  double overlap = 0;
  double tool = 0;  // m, radius of the tool's ball that cut the sphere

  bool operator==(const CutSphere&) const = default;
  double radius() const { return std::max(0.0, base_radius - 0.5 * overlap); }
  dvec3 center() const { return base + 0.5 * overlap * away; }
};
static_assert(sizeof(CutSphere) == 10 * sizeof(double));

}  // namespace packing

/// A sphere of the tool that moves by `way`. Metres, workbench frame W.
struct SweptBall {
  dvec3 from{0}, way{0};
  double radius = 0;
};
/// A sphere of the tool at rest. Metres, workbench frame W.
struct RestingBall {
  dvec3 p{0};
  double radius = 0;
};
/// A sphere of the tool that cuts on its path from `from` to `to`. Only tissue spheres near the path from `from` to
/// `near_to` are examined; `near_to` lies at `to` or beyond it. Metres, workbench frame W.
struct CuttingBall {
  dvec3 from{0}, to{0}, near_to{0};
  double radius = 0;
};

/// The first contact between spheres of the tool and spheres of the tissue. If several contacts occur at the same time,
/// the one with the lowest index `ball` counts. Among those, the one with the lowest index `sphere` counts.
struct FirstContact {
  // fraction of the path at the contact, 0 to 1; infinity: no contact
  double t = std::numeric_limits<double>::infinity();
  // index of the tool's sphere and of the tissue's sphere; -1: no contact
  int ball = -1, sphere = -1;
};
/// A pair of a tool sphere and a tissue sphere, with the volume of their overlap or of the removal, m³.
struct SphereShare {
  std::uint32_t ball, sphere;
  double volume;
};
/// The state of a tissue sphere after a tool sphere has cut it.
struct SphereChange {
  std::uint32_t ball, sphere;
  packing::CutSphere after;
};

/// The three passes (first contact, overlap, removal) on a GPU. Used by one thread at a time; after set-up, by the
/// servo thread. All results have the same bits as on the CPU. The returned lists are not sorted. If a function returns
/// false, the tissue on the GPU is unknown, and load() must be called before any other function.
class SpherePasses {
 public:
  virtual ~SpherePasses() = default;

  /// Returns the name of the GPU, for messages.
  virtual std::string device() const = 0;
  /// spheres(): number of spheres of the tissue. most_balls(): largest number of spheres of a tool.
  virtual std::size_t spheres() const noexcept = 0;
  virtual std::size_t most_balls() const noexcept = 0;

  /// Copies the whole tissue to the GPU; `tissue` must contain spheres() elements.
  virtual bool load(std::span<const packing::CutSphere> tissue, packing::Removal removal) noexcept = 0;

  /// Pass 1: finds the first contact on the path of the tool's spheres.
  virtual bool first_contact(std::span<const SweptBall> balls, FirstContact& first) noexcept = 0;
  /// Pass 2: finds all pairs of spheres that overlap, with the overlap's volume. The list is valid until the next call.
  virtual bool overlaps(std::span<const RestingBall> balls, std::span<const SphereShare>& found) noexcept = 0;
  /// Does the same as pass 3, but does not change the tissue: computes the volume that each tool sphere would remove
  /// from each tissue sphere. The tool spheres cut one after the other, so what one sphere removes is not counted again
  /// for the next one.
  virtual bool measure_removal(std::span<const CuttingBall> balls, std::span<const SphereShare>& found) noexcept = 0;
  /// Pass 3: cuts the tissue with the tool's spheres, one after the other. Returns all changes of each tissue sphere.
  virtual bool remove(std::span<const CuttingBall> balls, std::span<const SphereChange>& found) noexcept = 0;
};

/// A function that creates the passes at set-up, for a given number of tissue spheres. Returns null if no GPU can run
/// them. A software GPU is used only if `any_device` is true, for tests and measurements.
using SpherePassesMaker = std::function<std::unique_ptr<SpherePasses>(std::size_t spheres, bool any_device)>;

/// Registers, before main(), a function that creates the passes. Declare an object at namespace scope:
///   const SpherePassesRegistration registration{make_vulkan_sphere_passes};
struct SpherePassesRegistration {
  explicit SpherePassesRegistration(SpherePassesMaker maker);
};
/// Calls the registered function; returns null if none is registered.
std::unique_ptr<SpherePasses> make_sphere_passes(std::size_t spheres, bool any_device);

}  // namespace typodont::haptics
