#include "haptics/contact/packing/compute_passes.h"

#include <algorithm>
#include <cstring>
#include <tuple>
#include <utility>

#include "engine/base/clock.h"

namespace typodont::haptics {

namespace {

SpherePassesMaker& maker() {
  static SpherePassesMaker make;
  return make;
}

}  // namespace

SpherePassesRegistration::SpherePassesRegistration(SpherePassesMaker make) {
  maker() = std::move(make);
}

std::unique_ptr<SpherePasses> make_sphere_passes(std::size_t spheres, bool any_device) {
  return maker() ? maker()(spheres, any_device) : nullptr;
}

namespace packing {

namespace {

constexpr double kEpsilon = 0.05e-3;  // m, enlargement of the tool's spheres in estimate_surface()
// Largest number of results of a pass on the GPU; a pass with more results fails.
constexpr std::size_t kExpected = 65536;

/// Sorts results by the tool's ball; for equal balls, by the order of the tissue's spheres in the tree.
template <class Result>
void order(const SphereTree& tree, std::vector<Result>& results) noexcept {
  std::sort(results.begin(), results.end(), [&](const Result& a, const Result& b) {
    return a.ball != b.ball ? a.ball < b.ball
                            : tree.rank(static_cast<int>(a.sphere)) < tree.rank(static_cast<int>(b.sphere));
  });
}

/// Copies `from` to `to`; returns false if `to` is too small.
template <class Result>
bool take(std::span<const Result> from, std::vector<Result>& to) noexcept {
  if (from.size() > to.capacity()) return false;
  to.assign(from.begin(), from.end());
  return true;
}

/// Pass 1 (first contact) on the CPU, by a search in the tree.
FirstContact by_tree(const SphereTree& tree, std::span<const SweptBall> balls) noexcept {
  FirstContact first;
  for (std::size_t k = 0; k < balls.size(); ++k) {
    const SphereTree::Hit hit = tree.first_hit(balls[k].from, balls[k].radius, balls[k].motion);
    if (hit && hit.t < first.t) first = {hit.t, static_cast<int>(k), hit.sphere};
  }
  return first;
}

}  // namespace

ComputePasses::ComputePasses(std::unique_ptr<SpherePasses> passes, std::span<const ToolSpheres> tools)
    : passes_(std::move(passes)) {
  std::size_t most = 0;
  for (const ToolSpheres& tool : tools) most = std::max(most, tool.size());
  resting_.reserve(most), cutting_.reserve(most), number_.reserve(most);
  const std::size_t results = std::max(kExpected, passes_->spheres() / 4);
  shares_.reserve(results), changes_.reserve(results);
  loaded_.resize(passes_->spheres());
}

void ComputePasses::load(const SphereTissue& tissue) noexcept {
  ready_ = tissue.size() == loaded_.size();
  if (!ready_) return;
  for (std::size_t i = 0; i < loaded_.size(); ++i) loaded_[i] = tissue.sphere(static_cast<int>(i));
  ready_ = passes_->load(loaded_, tissue.removal());
}

bool ComputePasses::first_contact(std::span<const SweptBall> balls, FirstContact& first) noexcept {
  first = {};
  if (balls.empty()) return true;
  return ready_ = ready_ && passes_->first_contact(balls, first);
}

bool ComputePasses::estimate_surface(const SphereTissue& tissue, const ToolSpheres& tool, const Pose& X_WP,
                                     const dvec3& p_WC, double epsilon, const PerTissue& density,
                                     SurfaceEstimate& estimate) noexcept {
  resting_.clear(), number_.clear();
  for (std::size_t t = 0; t < tool.head; ++t) {
    const dvec3 c = X_WP * tool.center_T[t];
    if (glm::distance(c, p_WC) - tool.radius[t] > epsilon) continue;
    resting_.push_back({c, tool.radius[t] + epsilon});
    number_.push_back(static_cast<std::uint32_t>(t));
  }
  std::span<const SphereShare> found;
  if (!resting_.empty()) {
    ready_ = ready_ && passes_->overlaps(resting_, found);
    if (!ready_) return false;
  }
  if (!take(found, shares_)) return ready_ = false;
  order(tissue.tree(), shares_);
  OverlapSum sum(tissue, density);
  for (const SphereShare& s : shares_) {
    sum.add(resting_[s.ball].p, tissue.tree().place_of(static_cast<int>(s.sphere)), s.volume);
  }
  estimate = sum.estimate();
  return ready_;
}

void ComputePasses::put_cutting(const ToolSpheres& tool, const Pose& from, const Pose& to,
                                const Pose& near_to) noexcept {
  cutting_.clear();
  for (std::size_t t = 0; t < tool.head; ++t) {
    cutting_.push_back(
        {from * tool.center_T[t], to * tool.center_T[t], near_to * tool.center_T[t], tool.radius[t], tool.curve[t]});
  }
}

bool ComputePasses::cost(const SphereTissue& tissue, const ToolSpheres& tool, const Pose& from, const Pose& to,
                         const Pose& near_to, const PerTissue& energy, double& joules) noexcept {
  put_cutting(tool, from, to, near_to);
  std::span<const SphereShare> found;
  ready_ = ready_ && passes_->measure_removal(cutting_, found) && take(found, shares_);
  if (!ready_) return false;
  order(tissue.tree(), shares_);
  joules = 0;
  for (std::size_t k = 0; k < shares_.size();) {
    double of_ball = 0;
    const std::uint32_t ball = shares_[k].ball;
    for (; k < shares_.size() && shares_[k].ball == ball; ++k) {
      const int i = static_cast<int>(shares_[k].sphere);
      of_ball += shares_[k].volume * tissue.hardness(i) * energy[static_cast<std::size_t>(tissue.tissue(i))];
    }
    joules += of_ball;
  }
  return true;
}

bool ComputePasses::carve(SphereTissue& tissue, const ToolSpheres& tool, const Pose& X_WA, const Pose& X_WB,
                          Removed& removed, bool& changed) noexcept {
  put_cutting(tool, X_WA, X_WB, X_WB);
  std::span<const SphereChange> found;
  ready_ = ready_ && passes_->remove(cutting_, found) && take(found, changes_);
  if (!ready_) return false;
  order(tissue.tree(), changes_);
  for (const SphereChange& c : changes_) tissue.take(static_cast<int>(c.sphere), c.after, removed);
  changed = !changes_.empty();
  return true;
}

PassTimes compare_passes(const SphereTissue& tissue, const ToolSpheres& tool, ComputePasses& passes,
                         CutBuffers& buffers, int looks) {
  PassTimes times;
  PerTissue one;
  one.fill(1);
  std::vector<SweptBall> swept;
  TriedCut tried(tissue.size());
  const auto same = [](const auto& a, const auto& b) { return std::memcmp(&a, &b, sizeof a) == 0; };
  for (int look = 0; look < looks; ++look) {
    // For the test, the tool's first sphere moves into a sphere of the tissue, by a fifth of that sphere's radius.
    const auto number =
        static_cast<int>(tissue.size() * static_cast<std::size_t>(2 * look + 1) / static_cast<std::size_t>(2 * looks));
    const dvec3 way(0, 0, -0.2 * tool.radius[0]);
    const Pose at{tissue.tree().center(number) - tool.center_T[0] + dvec3(0, 0, tool.radius[0]) - 0.5 * way,
                  {1, 0, 0, 0}};
    const Pose to{at.p + way, at.R};
    swept.clear();
    for (std::size_t t = 0; t < tool.size(); ++t) swept.push_back({at * tool.center_T[t], way, tool.radius[t]});

    Nanos start = now();
    const FirstContact contact = by_tree(tissue.tree(), swept);
    const SurfaceEstimate surface =
        estimate_surface(tissue, tool, to, to * tool.center_T[0], kEpsilon, one, buffers.changed);
    double joules = 0;
    tried.begin(tool.head);
    for (std::size_t t = 0; t < tool.head; ++t) {
      const dvec3 a = at * tool.center_T[t], b = to * tool.center_T[t];
      const std::size_t near =
          std::min(tissue.tree().near_segment(a, b, tool.radius[t], buffers.changed), buffers.changed.size());
      joules += tried.add(tissue, std::span(buffers.changed).first(near), a, b, tool.radius[t], tool.curve[t], one);
    }
    times.processor += to_seconds(now() - start);

    FirstContact gpu_contact;
    SurfaceEstimate gpu_surface;
    double gpu_joules = 0;
    start = now();
    const bool ran = passes.first_contact(swept, gpu_contact) &&
                     passes.estimate_surface(tissue, tool, to, to * tool.center_T[0], kEpsilon, one, gpu_surface) &&
                     passes.cost(tissue, tool, at, to, to, one, gpu_joules);
    times.gpu += to_seconds(now() - start);
    times.same = times.same && ran &&
                 std::tie(contact.t, contact.ball, contact.sphere) ==
                     std::tie(gpu_contact.t, gpu_contact.ball, gpu_contact.sphere) &&
                 same(surface, gpu_surface) && same(joules, gpu_joules);
  }
  times.processor /= looks, times.gpu /= looks;
  return times;
}

}  // namespace packing

}  // namespace typodont::haptics
