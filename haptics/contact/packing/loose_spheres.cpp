#include "haptics/contact/packing/loose_spheres.h"

#include <algorithm>
#include <numeric>
#include <utility>

namespace typodont::haptics::packing {

namespace {

/// Two spheres are linked at the start if their gap divided by the smaller radius is at most this. Large, so that links
/// also reach the next deeper layer of spheres. Such a link remains when a cut from above shrinks the upper sphere.
constexpr double kLink = 1.5;
// m; a link breaks if the gap has grown by this and exceeds the sum of radii. Smaller than any tool's diameter.
constexpr double kWidened = 0.1e-3;
// number of spheres that one flood fill visits before the next one continues
constexpr int kPace = 16;

/// Returns true if two spheres are still linked. `gap_at_start`: m, gap between them before any cut.
bool holds(double ri, double rj, double distance, double gap_at_start) {
  if (!(ri > 0 && rj > 0)) return false;
  const double gap = distance - ri - rj;
  return gap < std::max(ri + rj, gap_at_start + kWidened);
}

struct Flood {
  std::vector<int> reached;  // all spheres that this flood fill has reached
  std::size_t done = 0;      // number of spheres in `reached` that were visited
};

}  // namespace

LooseSpheres::LooseSpheres(const SpherePacking& packing, const SphereTree& tree)
    : body_(packing.size(), -1),
      before_(packing.size()),
      cut_(packing.size(), 0),
      seen_(packing.size(), 0),
      flood_(packing.size(), 0) {
  std::vector<Place> near(packing.size());
  for (std::size_t i = 0; i < packing.size(); ++i) {
    first_.push_back(links_.size());
    const double r = packing.radius[i];
    const std::size_t found = tree.near_segment(packing.center[i], packing.center[i], (1 + kLink) * r, near);
    for (std::size_t k = 0; k < found; ++k) {
      const int other = tree.sphere_in(near[k]);
      const auto j = static_cast<std::size_t>(other);
      const double gap = glm::distance(packing.center[i], packing.center[j]) - r - packing.radius[j];
      if (j != i && gap < kLink * std::min(r, packing.radius[j])) links_.push_back({other, static_cast<float>(gap)});
    }
  }
  first_.push_back(links_.size());
  std::vector<int> queue;
  int bodies = 0;
  for (std::size_t i = 0; i < packing.size(); ++i) {
    if (body_[i] >= 0) continue;
    body_[i] = bodies;
    queue.assign(1, static_cast<int>(i));
    while (!queue.empty()) {
      const int at = queue.back();
      queue.pop_back();
      for (const Link& link : links(at)) {
        if (int& body = body_[static_cast<std::size_t>(link.to)]; body < 0) body = bodies, queue.push_back(link.to);
      }
    }
    ++bodies;
  }
}

bool LooseSpheres::hold(const SphereTissue& tissue, int i, const Link& link) {
  const SphereTree& tree = tissue.tree();
  return holds(tree.radius(i), tree.radius(link.to), glm::distance(tree.center(i), tree.center(link.to)),
               static_cast<double>(link.gap));
}

/// Returns true if the link existed before the current cut.
bool LooseSpheres::linked_before(const SphereTissue& tissue, const Changed& i, const Link& link) const {
  const auto k = static_cast<std::size_t>(link.to);
  const bool both = cut_[k] == cuts_;
  const dvec3 center = both ? before_[k].center : tissue.tree().center(link.to);
  const double radius = both ? before_[k].radius : tissue.tree().radius(link.to);
  return holds(i.radius, radius, glm::distance(i.center, center), static_cast<double>(link.gap));
}

std::vector<std::vector<int>> LooseSpheres::after_cut(const SphereTissue& tissue, std::span<const Changed> changed) {
  ++cuts_;
  for (const Changed& c : changed) {
    before_[static_cast<std::size_t>(c.sphere)] = c;
    cut_[static_cast<std::size_t>(c.sphere)] = cuts_;
  }
  // Flood fills start at the spheres whose links the current cut has broken (seeds).
  std::vector<int> seeds;
  const auto seed = [&](int i) {
    if (tissue.tree().radius(i) > 0) seeds.push_back(i);
  };
  for (const Changed& c : changed) {
    const auto own = links(c.sphere);
    const bool broke = std::any_of(own.begin(), own.end(), [&](const Link& link) {
      return !hold(tissue, c.sphere, link) && linked_before(tissue, c, link);
    });
    if (!broke) continue;
    seed(c.sphere);
    for (const Link& link : own) seed(link.to);
  }
  std::vector<std::vector<int>> loose;
  const auto body = [&](int i) { return body_[static_cast<std::size_t>(i)]; };
  std::sort(seeds.begin(), seeds.end(), [&](int a, int b) { return body(a) != body(b) ? body(a) < body(b) : a < b; });
  seeds.erase(std::unique(seeds.begin(), seeds.end()), seeds.end());
  for (std::size_t begin = 0, end; begin < seeds.size(); begin = end) {
    end = begin;
    while (end < seeds.size() && body(seeds[end]) == body(seeds[begin])) ++end;
    if (end - begin > 1) flood(tissue, std::span(seeds).subspan(begin, end - begin), loose);
  }
  return loose;
}

/// Flood fills along the links, from all `seeds`, which belonged to one connected body before the cut.
void LooseSpheres::flood(const SphereTissue& tissue, std::span<const int> seeds, std::vector<std::vector<int>>& loose) {
  ++search_;
  std::vector<Flood> floods(seeds.size());
  std::vector<int> joined(seeds.size());  // for each flood fill: the one with which it was merged
  std::iota(joined.begin(), joined.end(), 0);
  const auto root = [&](int f) {
    while (joined[static_cast<std::size_t>(f)] != f) f = joined[static_cast<std::size_t>(f)];
    return f;
  };
  const auto reach = [&](int i, int f) {
    seen_[static_cast<std::size_t>(i)] = search_;
    flood_[static_cast<std::size_t>(i)] = f;
    floods[static_cast<std::size_t>(f)].reached.push_back(i);
  };
  for (std::size_t f = 0; f < seeds.size(); ++f) reach(seeds[f], static_cast<int>(f));

  std::vector<int> active(joined), next;
  std::size_t ended = loose.size();
  while (active.size() > 1) {
    next.clear();
    for (const int f : active) {
      if (root(f) != f) continue;
      Flood& own = floods[static_cast<std::size_t>(f)];
      int into = f;
      for (int k = 0; k < kPace && own.done < own.reached.size() && into == f; ++k) {
        const int at = own.reached[own.done++];
        for (const Link& link : links(at)) {
          const int j = link.to;
          if (!hold(tissue, at, link)) continue;
          if (seen_[static_cast<std::size_t>(j)] != search_) {
            reach(j, into);
          } else if (const int other = root(flood_[static_cast<std::size_t>(j)]); other != into) {
            // Two flood fills have met: appends the smaller list of spheres to the larger one. The merged fill visits
            // all appended spheres, some of them for the second time.
            Flood &a = floods[static_cast<std::size_t>(into)], &b = floods[static_cast<std::size_t>(other)];
            const bool to_other = b.reached.size() > a.reached.size();
            Flood &from = to_other ? a : b, &to = to_other ? b : a;
            to.reached.insert(to.reached.end(), from.reached.begin(), from.reached.end());
            from = {};
            joined[static_cast<std::size_t>(to_other ? into : other)] = to_other ? other : into;
            into = to_other ? other : into;
          }
        }
      }
      Flood& now = floods[static_cast<std::size_t>(into)];
      if (into == f && now.done >= now.reached.size()) {
        // this flood fill ended without meeting another, so its spheres are a loose piece
        loose.push_back(std::move(now.reached));
      } else if (into == f) {
        next.push_back(f);
      }
    }
    std::erase_if(next, [&](int f) { return root(f) != f; });
    std::swap(active, next);
  }
  // If all flood fills have ended without meeting, the largest one is the main body, not a loose piece.
  if (active.empty() && loose.size() > ended) {
    const auto most = std::max_element(loose.begin() + static_cast<std::ptrdiff_t>(ended), loose.end(),
                                       [](const auto& a, const auto& b) { return a.size() < b.size(); });
    loose.erase(most);
  }
}

}  // namespace typodont::haptics::packing
