#include "engine/app/hands/stroke_planner.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstdint>
#include <map>
#include <optional>
#include <unordered_map>

#include "engine/base/in_parallel.h"
#include "engine/base/units.h"
#include "engine/base/voxels.h"
#include "haptics/sweep.h"

namespace typodont {

namespace {

// Depth to which the head may enter the ideal shape, voxels: the error of the distance field.
constexpr double kPlannedClear = 0.05;
// Depth to which a head that fits the ideal shape exactly (a reamer) may enter this shape, voxels.
constexpr double kExact = 0.02;
constexpr double kGrid = 0.1e-3;      // m, distance between the positions of the tool's head that are evaluated
constexpr double kLayer = 0.5;        // distance between layers of bulk removal, in tool diameters
constexpr double kCoarseLayer = 0.8;  // distance between layers for a coarse tool, in tool diameters
// In tool diameters. A coarse tool does not remove tissue in rows if its height above the cavity's floor is less than
// this, because passes along the floor remove this tissue.
constexpr double kAtOnce = 0.5;
constexpr double kRow = 0.6;  // distance between rows (parallel passes) of a layer, in tool diameters
// Largest height difference of floor points that count as level, m.
constexpr double kSameLevel = 10e-6;
// Smallest flat floor that gets passes along its walls, m².
constexpr double kMinFlat = 0.1e-6;
// Smallest flat part of the floor that gets passes along its walls, as a fraction of the head's cross-section.
constexpr double kFlatShare = 0.15;
// A row ends at this distance from a wall, in tool diameters. A separate pass cuts along the wall.
constexpr double kFromWall = 0.45;
constexpr double kMinTaken = 0.05;  // voxels; thinner tissue gets no stroke
// A point of a path is omitted if it is nearer than this to the line between its neighbours, m.
constexpr double kOnLine = 2e-6;
// If a part of a pass without cutting is shorter than this, the tool moves along it and is not lifted, m.
constexpr double kBridged = 1e-3;
// For a coarse tool: if a part of a pass without cutting is shorter than this, the tool is not lifted, m.
constexpr double kCoarseBridged = 3e-3;
// If the next pass is farther away than this, the tool moves up, across and down, m.
constexpr double kStraight = 3e-3;
constexpr double kHop = 0.3e-3;  // m, height step in the search for a free path
// A row (parallel pass) longer than this begins with a ramp that descends from the layer above, m.
constexpr double kRamp = 0.8e-3;
// A pass is divided where the slope of the floor (height per length) is larger than this.
constexpr double kSteep = 2;
constexpr double kAlongShank = 6e-3;     // m, length of the shank that is checked for collisions
constexpr double kDown = 0.1e-3;         // m, step in which the head is lowered
constexpr double kFloorOfColumn = 1e-6;  // m, precision of the lowest height that the head can reach
constexpr int kHeadPoints = 360, kShankPoints = 60;
constexpr double kFieldErrorLimit = 1;  // voxels, largest error of the distance field far from the surface
// Largest number of points on the tool's head in a leaf of the tree of spheres.
constexpr std::size_t kTogether = 12;
constexpr int kBisectionSteps = 7;  // number of bisection steps between two grid positions

/// Plans the strokes. Positions (a, b, c) of the head's centre are in m along u, v, w; w points out of the opening.
class StrokePlanner {
 public:
  StrokePlanner(const session::Preparation& in, const haptics::Tool& tool, const StrokeOptions& options)
      : options_(options),
        min_taken_(std::max(kMinTaken / options.size, options.least / in.frame.voxel)),
        in_(in),
        tool_(tool),
        ideal_(in.ideal),
        left_(in.before),
        R_WT_(toward(in.axis_W)),
        axes_(R_WT_),
        allowed_(kPlannedClear + options.into / in.frame.voxel) {
    const double h = in.frame.voxel;
    std::vector<dvec3> head, shank;
    for (const haptics::HeadSample& s : haptics::sample_head(tool, kHeadPoints, 0.4))
      head.push_back(R_WT_ * s.p_TQ / h);
    if (const auto part = haptics::shank_of(tool)) {
      for (const haptics::HeadSample& s : haptics::sample_head(part->shape, kShankPoints)) {
        const dvec3 p_TQ = s.p_TQ + dvec3(0, 0, part->z);
        if (p_TQ.z < tool.half() + kAlongShank) shank.push_back(R_WT_ * p_TQ / h);
      }
    }
    add_tree(std::move(head), head_tree_);
    add_tree(std::move(shank), shank_tree_);
  }

  StrokePlan plan() {
    if (find_bounds()) add_all();
    return {std::move(strokes_), std::move(left_)};
  }

 private:
  void add_all() {
    if (auto way = close_fit()) take(*way, /*closed=*/false);
    find_layers();
    for (Layer& layer : layers_) {
      rows(layer);
      for (Chain& wall : walls_at(layer.height)) take(wall, /*closed=*/true);
    }
    if (!options_.finish || layers_.empty()) return;
    bulk_ = false;
    // Cuts along the walls, first at the heights of the floor's flat
    // parts, then upwards: a long head cuts a steep wall in one pass.
    for (const double height : floors())
      for (Chain& wall : walls_at(height)) take(wall, /*closed=*/true);
    for (double height = layers_.back().height; height < layers_.front().height; height += options_.step) {
      for (Chain& wall : walls_at(height)) take(wall, /*closed=*/true);
    }
  }

  using Chain = std::vector<dvec3>;
  struct Layer {
    double height = 0;             // m, height of the layer
    std::vector<std::uint8_t> in;  // for each grid position: 1 if reachable from above
  };

  /// A sphere around points on the tool's head, voxels. A leaf contains its points; the parts of any other sphere
  /// follow it in the tree.
  struct Points {
    dvec3 center{0};
    double radius = 0;
    std::size_t next = 0;  // index of the first sphere after all parts of this one
    std::vector<dvec3> points;
  };
  using Tree = std::vector<Points>;
  /// Appends a tree of spheres; each sphere is split across the longest side of its points.
  static void add_tree(std::vector<dvec3> points, Tree& tree) {
    if (points.empty()) return;
    dvec3 lo = points.front(), hi = lo;
    for (const dvec3& p : points) lo = glm::min(lo, p), hi = glm::max(hi, p);
    const std::size_t at = tree.size();
    tree.push_back({0.5 * (lo + hi), 0, at + 1, {}});
    for (const dvec3& p : points) tree[at].radius = std::max(tree[at].radius, glm::distance(p, tree[at].center));
    if (points.size() <= kTogether) {
      tree[at].points = std::move(points);
      return;
    }
    const dvec3 side = hi - lo;
    const int axis = side.x >= side.y && side.x >= side.z ? 0 : side.y >= side.z ? 1 : 2;
    const auto middle = points.begin() + static_cast<std::ptrdiff_t>(points.size() / 2);
    std::nth_element(points.begin(), middle, points.end(),
                     [&](const dvec3& a, const dvec3& b) { return a[axis] < b[axis]; });
    add_tree({points.begin(), middle}, tree);
    add_tree({middle, points.end()}, tree);
    tree[at].next = tree.size();
  }
  enum class Inside { kAll, kNone, kSome };
  /// Index of the first sphere with a point for which `holds` is false; the tree's size if there is none. `test`:
  /// whether it holds for all, none or some points of a sphere.
  template <class Test, class Holds>
  static std::size_t first_without(const Tree& tree, const Test& test, const Holds& holds) {
    for (std::size_t k = 0; k < tree.size();) {
      const Points& sphere = tree[k];
      const Inside inside = test(sphere);
      if (inside == Inside::kNone) return k;
      if (inside == Inside::kSome && !std::all_of(sphere.points.begin(), sphere.points.end(), holds)) return k;
      k = inside == Inside::kAll ? sphere.next : k + 1;
    }
    return tree.size();
  }
  template <class Test, class Holds>
  static bool all_points(const Tree& tree, const Test& test, const Holds& holds) {
    return first_without(tree, test, holds) == tree.size();
  }

  dvec3 world(const dvec3& p) const { return axes_ * p; }
  dvec3 voxels(const dvec3& p) const { return in_.frame.to_voxels(world(p)); }

  /// True if the head at p (m along u, v, w) does not enter the target shape.
  bool clear(const dvec3& p) const {
    const dvec3 q = voxels(p);
    // Neighbouring positions enter the shape with the same part of the head.
    const std::size_t entered = entered_.load(std::memory_order_relaxed);
    if (entered < head_tree_.size() && std::any_of(head_tree_[entered].points.begin(), head_tree_[entered].points.end(),
                                                   [&](const dvec3& d) { return ideal_.sample(q + d) <= -allowed_; }))
      return false;
    const auto first_entering = [&](const Tree& tree, double into) {
      return first_without(
          tree,
          [&](const Points& sphere) {
            const double distance = ideal_.sample(q + sphere.center), near = sphere.radius + kFieldErrorLimit;
            return distance > near ? Inside::kAll : distance < -near - into ? Inside::kNone : Inside::kSome;
          },
          [&](const dvec3& d) { return ideal_.sample(q + d) > -into; });
    };
    const std::size_t entering = first_entering(head_tree_, allowed_);
    if (entering < head_tree_.size()) {
      entered_.store(entering, std::memory_order_relaxed);
      return false;
    }
    return first_entering(shank_tree_, 0) == shank_tree_.size() && (!options_.around || clears_surroundings(world(p)));
  }
  /// True if the head at p_W (m) does not touch neighbouring teeth and gum. Gum inside the tooth is ignored.
  bool clears_surroundings(const dvec3& p_W) const {
    const double h = in_.frame.voxel;
    return all_points(
        head_tree_,
        [&](const Points& sphere) {
          const dvec3 q_W = p_W + h * sphere.center;
          const double near = h * sphere.radius + options_.clearance;
          return options_.around->neighbour(q_W) > near && options_.around->gum(q_W) > near ? Inside::kAll
                                                                                            : Inside::kSome;
        },
        [&](const dvec3& d) {
          const dvec3 q_W = p_W + h * d;
          return options_.around->neighbour(q_W) > options_.clearance &&
                 (options_.around->gum(q_W) > options_.clearance || options_.around->tooth(q_W) <= 0);
        });
  }
  /// True if the head at p removes tissue.
  bool useful(const dvec3& p) const {
    const dvec3 q = voxels(p);
    return !all_points(
        head_tree_,
        [&](const Points& sphere) {
          const dvec3 center = q + sphere.center;
          const double near = sphere.radius + kFieldErrorLimit;
          return left_.sample(center) > near || ideal_.sample(center) < -near ? Inside::kAll : Inside::kSome;
        },
        [&](const dvec3& d) { return !(left_.sample(q + d) < -min_taken_ && ideal_.sample(q + d) > 0); });
  }

  /// Computes the box of the tissue to remove, enlarged by the size of the head. False: there is nothing to remove.
  bool find_bounds() {
    dvec3 lo(1e9), hi(-1e9);
    for_each_voxel(in_.before.size, [&](int x, int y, int z) {
      const std::size_t i = in_.before.at(x, y, z);
      if (in_.before.distance[i] > 0 || in_.ideal.distance[i] <= 0) return;
      const dvec3 p = glm::transpose(axes_) * in_.frame.to_world(dvec3(x, y, z));
      lo = glm::min(lo, p);
      hi = glm::max(hi, p);
    });
    if (lo.x > hi.x) return false;
    lo_ = {lo.x - tool_.radius() - grid_, lo.y - tool_.radius() - grid_};
    top_ = hi.z + tool_.half() + down_;
    bottom_ = lo.z - tool_.half();
    for (int k = 0; k < 2; ++k)
      count_[k] = static_cast<int>(std::ceil((hi[k] + tool_.radius() + grid_ - lo_[k]) / grid_)) + 1;
    return true;
  }
  std::size_t cell(int i, int j) const {
    return static_cast<std::size_t>(i) * static_cast<std::size_t>(count_.y) + static_cast<std::size_t>(j);
  }
  /// Calls what(i) for all columns of the grid, on several threads.
  template <class What>
  void each_column(const What& what) const {
    constexpr std::size_t kBlock = 8;
    in_parallel(
        static_cast<std::size_t>(count_.x), [&](std::size_t i) { what(static_cast<int>(i)); }, {}, kBlock);
  }
  dvec3 place(int i, int j, double height) const { return {lo_.x + i * grid_, lo_.y + j * grid_, height}; }

  /// Distance from a head at p to the target shape, voxels; negative inside.
  double clearance(const dvec3& p) const {
    const dvec3 q = voxels(p);
    double least = kFieldErrorLimit;
    all_points(
        head_tree_,
        [&](const Points& sphere) {
          return ideal_.sample(q + sphere.center) > sphere.radius + kFieldErrorLimit ? Inside::kAll : Inside::kSome;
        },
        [&](const dvec3& d) {
          least = std::min(least, ideal_.sample(q + d));
          return true;
        });
    return least;
  }
  /// Position near p, at the same height, farthest from the ideal shape: tries eight directions, halving the step.
  dvec3 centered(dvec3 p) const {
    constexpr std::array<glm::dvec2, 8> kDirections{
        {{1, 0}, {-1, 0}, {0, 1}, {0, -1}, {1, 1}, {1, -1}, {-1, 1}, {-1, -1}}};
    double best = clearance(p);
    for (double step = 4 * grid_; step > floor_of_column_;) {
      dvec3 next = p;
      for (const glm::dvec2& d : kDirections) {
        const dvec3 q = p + dvec3(step * d, 0);
        if (const double room = clearance(q); room > best) best = room, next = q;
      }
      if (next == p) step *= 0.5;
      p = next;
    }
    return p;
  }
  /// Straight path for a head that fits the target shape exactly and has no free grid position beside it, such as a hip
  /// reamer. Empty for other heads.
  std::optional<Chain> close_fit() const {
    dvec3 p = centered({lo_ + 0.5 * grid_ * glm::dvec2(count_ - 1), top_});
    const auto down_to = [&](double height) {
      dvec3 q(p.x, p.y, height);
      if (!(clearance(q) > -kExact)) q = centered(q);
      if (!(clearance(q) > -kExact) || !clear(q)) return false;
      p = q;
      return true;
    };
    while (p.z > bottom_ && down_to(p.z - down_)) continue;
    for (double step = 0.5 * down_; step > floor_of_column_; step *= 0.5) down_to(p.z - step);
    const auto beside = [&](double x, double y) { return clear(p + grid_ * dvec3(x, y, 0)); };
    const dvec3 above(p.x, p.y, top_);
    if (beside(1, 0) || beside(-1, 0) || beside(0, 1) || beside(0, -1) || !clear_along(above, p)) return std::nullopt;
    return Chain{above, p};
  }

  /// Grid positions that the tool's head can reach from the layer `above` (null: this is the highest layer).
  Layer layer_at(double height, const Layer* above) const {
    Layer layer{height, std::vector<std::uint8_t>(cell(count_.x - 1, count_.y - 1) + 1)};
    std::vector<std::uint8_t> free(layer.in.size());
    std::vector<glm::ivec2> open;
    each_column([&](int i) {
      for (int j = 0; j < count_.y; ++j) free[cell(i, j)] = clear(place(i, j, height));
    });
    for (int i = 0; i < count_.x; ++i) {
      for (int j = 0; j < count_.y; ++j) {
        if (!free[cell(i, j)] || (above && !above->in[cell(i, j)])) continue;
        layer.in[cell(i, j)] = 1;
        open.push_back({i, j});
      }
    }
    while (!open.empty()) {
      const glm::ivec2 at = open.back();
      open.pop_back();
      for (const glm::ivec2& d : {glm::ivec2(1, 0), glm::ivec2(-1, 0), glm::ivec2(0, 1), glm::ivec2(0, -1)}) {
        const glm::ivec2 to = at + d;
        if (to.x < 0 || to.y < 0 || to.x >= count_.x || to.y >= count_.y) continue;
        const std::size_t k = cell(to.x, to.y);
        if (layer.in[k] || !free[k]) continue;
        layer.in[k] = 1;
        open.push_back(to);
      }
    }
    return layer;
  }

  void find_layers() {
    for (double height = top_; height > bottom_; height -= layer_) {
      layers_.push_back(layer_at(height, layers_.empty() ? nullptr : &layers_.back()));
      const auto& in = layers_.back().in;
      if (std::none_of(in.begin(), in.end(), [](std::uint8_t v) { return v != 0; })) {
        layers_.pop_back();
        break;
      }
    }
  }
  /// The lowest layer at or above `height`.
  const Layer& layer_above(double height) const {
    const Layer* best = &layers_.front();
    for (const Layer& layer : layers_)
      if (layer.height >= height - 1e-9) best = &layer;
    return *best;
  }

  /// The last free position on the way from a free position to a position inside the ideal shape, by bisection.
  dvec3 border(dvec3 clear_place, dvec3 unclear) const {
    for (int k = 0; k < kBisectionSteps; ++k) {
      const dvec3 middle = 0.5 * (clear_place + unclear);
      (clear(middle) ? clear_place : unclear) = middle;
    }
    return clear_place;
  }

  /// The path `chain` without the points that lie on the line between their neighbours.
  Chain straightened(const Chain& chain) const {
    Chain result{chain.front()};
    std::size_t from = 0;
    while (from + 1 < chain.size()) {
      std::size_t to = from + 1;
      const auto straight = [&](std::size_t end) {
        const dvec3 way = chain[end] - chain[from];
        const double length = glm::length(way);
        if (length < 1e-9) return false;
        for (std::size_t k = from + 1; k < end; ++k) {
          const dvec3 d = chain[k] - chain[from];
          const double along = glm::dot(d, way) / length;
          if (along < 0 || glm::length(d - along / length * way) > on_line_) return false;
        }
        return true;
      };
      while (to + 1 < chain.size() && straight(to + 1)) ++to;
      result.push_back(chain[to]);
      from = to;
    }
    return result;
  }

  void stroke(const Chain& chain) {
    const Chain line = straightened(chain);
    go_to(line.front());
    if (line.size() == 1) add(line[0], line[0], false);
    for (std::size_t k = 0; k + 1 < line.size(); ++k) add(line[k], line[k + 1], k + 2 < line.size());
  }
  /// Adds a path to `to` that does not enter the target shape: straight, or up, across and down. If there is none, adds
  /// nothing; the hand then lifts the tool.
  void go_to(const dvec3& to) {
    if (!last_) return;
    const dvec3 from = *last_;
    if (glm::length(to - from) < on_line_) return;
    if (glm::length(to - from) < straight_ && clear_along(from, to)) return add(from, to, true);
    for (double height = std::max(from.z, to.z) + down_; height < top_; height += hop_) {
      const dvec3 up(from.x, from.y, height), over(to.x, to.y, height);
      if (!clear_along(up, over)) continue;
      if (!clear_along(from, up) || !clear_along(over, to)) return;
      const bool air = in_air(from, up) && in_air(up, over);
      add(from, up, false, air);
      add(up, over, false, air);
      const dvec3 contact = coarse_ && air ? until_contact(over, to) : over;
      if (contact != over) add(over, contact, false, true);
      return add(contact, to, coarse_);
    }
  }
  bool clear_along(const dvec3& from, const dvec3& to) const {
    const int looks = static_cast<int>(std::ceil(glm::length(to - from) / grid_));
    for (int k = 1; k < looks; ++k)
      if (!clear(from + static_cast<double>(k) / looks * (to - from))) return false;
    return true;
  }
  /// The last point before the head meets tissue.
  dvec3 until_contact(const dvec3& from, const dvec3& to) const {
    const int looks = static_cast<int>(std::ceil(glm::length(to - from) / grid_));
    dvec3 last = from;
    for (int k = 1; k < looks; ++k) {
      const dvec3 next = from + static_cast<double>(k) / looks * (to - from);
      if (useful(next)) break;
      last = next;
    }
    return last;
  }
  /// True if the head meets no tissue on the line.
  bool in_air(const dvec3& from, const dvec3& to) const {
    const int looks = static_cast<int>(std::ceil(glm::length(to - from) / grid_));
    for (int k = 1; k <= looks; ++k)
      if (useful(from + static_cast<double>(k) / looks * (to - from))) return false;
    return true;
  }
  void add(const dvec3& from, const dvec3& to, bool goes_on, bool in_air = false) {
    const Stroke s{{world(from), R_WT_}, {world(to), R_WT_}, goes_on, bulk_, in_air};
    strokes_.push_back(s);
    last_ = to;
    const haptics::Sweep sweep(tool_, s.from, s.to, in_.frame);
    const glm::ivec3 lo = glm::max(sweep.lo(), glm::ivec3(0)), hi = glm::min(sweep.hi(), left_.size - 1);
    if (glm::any(glm::lessThan(hi, lo))) return;
    const std::size_t at = left_.at(lo.x, lo.y, lo.z), row = static_cast<std::size_t>(left_.size.z);
    sweep.carve(lo, hi - lo + 1, &left_.distance[at], row * static_cast<std::size_t>(left_.size.y), row, nullptr,
                nullptr);
  }

  /// Plans strokes where the path removes tissue. `closed`: the path is closed, so it may begin anywhere.
  void take(Chain& chain, bool closed) {
    if (chain.empty()) return;
    std::vector<std::uint8_t> has(chain.size());
    in_parallel(chain.size(), [&](std::size_t k) { has[k] = useful(chain[k]); });
    closed = closed && chain.size() > 2 && glm::length(chain.front() - chain.back()) < 1e-9;
    if (closed) {  // begins at a point that removes nothing, so that no part is divided
      const auto idle = static_cast<std::ptrdiff_t>(std::find(has.begin(), has.end(), 0) - has.begin());
      if (idle > 0 && idle < static_cast<std::ptrdiff_t>(chain.size())) {
        chain.pop_back(), has.pop_back();
        const auto at = idle % static_cast<std::ptrdiff_t>(chain.size());
        std::rotate(chain.begin(), chain.begin() + at, chain.end());
        std::rotate(has.begin(), has.begin() + at, has.end());
        chain.push_back(chain.front()), has.push_back(has.front());
      }
    }
    for (std::size_t k = 0; k < chain.size();) {
      if (!has[k]) {
        ++k;
        continue;
      }
      std::size_t last = k;
      double idle = 0;
      for (std::size_t m = k + 1; m < chain.size() && idle < bridged_; ++m) {
        idle = has[m] ? 0 : idle + glm::length(chain[m] - chain[m - 1]);
        if (has[m]) last = m;
      }
      const std::size_t from = k > 0 ? k - 1 : 0, to = std::min(last + 1, chain.size() - 1);
      stroke(Chain(chain.begin() + static_cast<std::ptrdiff_t>(from),
                   chain.begin() + static_cast<std::ptrdiff_t>(to) + 1));
      k = to + 1;
    }
  }

  /// Plans bulk removal in a layer: rows along the layer's longer side; each row ends at a distance from the walls.
  void rows(const Layer& layer) {
    const auto from_wall = static_cast<int>(std::ceil(kFromWall * tool_.diameter / grid_));
    const std::vector<std::uint8_t> in = inner(layer.in, from_wall);
    std::vector<std::uint8_t> has(in.size());
    each_column([&](int i) {
      for (int j = 0; j < count_.y; ++j) has[cell(i, j)] = in[cell(i, j)] && useful(place(i, j, layer.height));
    });
    glm::ivec2 lo = count_, hi(-1);
    for (int i = 0; i < count_.x; ++i) {
      for (int j = 0; j < count_.y; ++j) {
        if (!has[cell(i, j)]) continue;
        lo = glm::min(lo, {i, j}), hi = glm::max(hi, {i, j});
      }
    }
    if (hi.x < 0) return;
    const bool along_x = hi.x - lo.x >= hi.y - lo.y;
    const int a = along_x ? 0 : 1, b = 1 - a;
    const auto apart = std::max(1, static_cast<int>(kRow * tool_.diameter / grid_));
    bool back = false;
    for (int row = lo[b];; row = std::min(row + apart, hi[b])) {
      std::vector<Chain> pieces;
      for (int k = lo[a]; k <= hi[a]; ++k) {
        const glm::ivec2 at = along_x ? glm::ivec2(k, row) : glm::ivec2(row, k);
        const bool inside = in[cell(at.x, at.y)] && !left_to_floor(place(at.x, at.y, layer.height));
        if (inside && (k == lo[a] || pieces.empty() || pieces.back().empty())) pieces.emplace_back();
        if (inside) pieces.back().push_back(place(at.x, at.y, layer.height));
        if (!inside && !pieces.empty() && !pieces.back().empty()) pieces.emplace_back();
      }
      if (back) {
        std::reverse(pieces.begin(), pieces.end());
        for (Chain& piece : pieces) std::reverse(piece.begin(), piece.end());
      }
      const std::size_t before = strokes_.size();
      for (Chain& piece : pieces) {
        if (row == lo[b]) enter(piece);
        take(piece, /*closed=*/false);
      }
      if (strokes_.size() > before) back = !back;
      if (row == hi[b]) break;
    }
  }

  /// True if the tissue at p is removed by a coarse tool's passes along the cavity's floor, so that p needs no row.
  bool left_to_floor(const dvec3& p) const {
    if (!coarse_) return false;
    const auto floor = lowest(p.x, p.y);
    return floor && p.z - *floor < kAtOnce * tool_.diameter;
  }

  /// Adds a ramp that descends from the layer above along the row, because a bur cuts badly with its end.
  void enter(const Chain& row) {
    if (row.size() < 2 || glm::length(row.back() - row.front()) < ramp_) return;
    if (std::none_of(row.begin(), row.end(), [&](const dvec3& p) { return useful(p); })) return;
    const dvec3 above = row.front() + dvec3(0, 0, layer_);
    if (above.z > top_ + down_ || !clear(above) || !clear_along(above, row.back())) return;
    stroke({above, row.back(), row.front()});
  }

  /// The marked grid cells that are more than `away` cells from all unmarked cells. The edge of the grid has no effect.
  std::vector<std::uint8_t> inner(const std::vector<std::uint8_t>& in, int away) const {
    // Distance to the nearest unmarked cell of the same column, at most away + 1 cells.
    std::vector<int> along(in.size(), away + 1);
    for (int i = 0; i < count_.x; ++i) {
      int up = away + 1, down = away + 1;
      for (int j = 0; j < count_.y; ++j) {
        up = in[cell(i, j)] ? std::min(up, away) + 1 : 0;
        along[cell(i, j)] = std::min(along[cell(i, j)], up);
        const int k = count_.y - 1 - j;
        down = in[cell(i, k)] ? std::min(down, away) + 1 : 0;
        along[cell(i, k)] = std::min(along[cell(i, k)], down);
      }
    }
    std::vector<std::uint8_t> result(in.size());
    each_column([&](int i) {
      for (int j = 0; j < count_.y; ++j) {
        bool free = true;
        for (int k = std::max(i - away, 0); free && k <= std::min(i + away, count_.x - 1); ++k) {
          const int d = along[cell(k, j)];
          free = (k - i) * (k - i) + d * d > away * away;
        }
        result[cell(i, j)] = free;
      }
    });
    return result;
  }

  /// Curves on which the head touches the target shape at this height, by marching squares (Lorensen & Cline 1987, in
  /// the plane).
  std::vector<Chain> walls_at(double height) const {
    const Layer& above = layer_above(height);
    const Layer layer = above.height - height < 1e-9 ? above : layer_at(height, &above);
    std::vector<std::array<dvec3, 2>> around;  // grid positions on both sides of each point of the outline
    // Key: grid edge; value: index of the outline's crossing point.
    std::unordered_map<std::size_t, std::size_t> index;
    std::vector<std::array<std::size_t, 2>> next;  // both neighbours of each point on its curve
    constexpr std::size_t kNone = SIZE_MAX;
    const auto point_on = [&](glm::ivec2 p, glm::ivec2 q) {
      if (cell(q.x, q.y) < cell(p.x, p.y)) std::swap(p, q);
      const std::size_t key = 2 * cell(p.x, p.y) + (q.x > p.x ? 1 : 0);
      const auto [it, fresh] = index.try_emplace(key, around.size());
      if (fresh) {
        const bool first = layer.in[cell(p.x, p.y)];
        const dvec3 in = place(first ? p.x : q.x, first ? p.y : q.y, height),
                    out = place(first ? q.x : p.x, first ? q.y : p.y, height);
        around.push_back({in, out});
        next.push_back({kNone, kNone});
      }
      return it->second;
    };
    const auto join = [&](std::size_t a, std::size_t b) {
      for (const auto& [from, to] : {std::pair(a, b), std::pair(b, a)})
        (next[from][0] == kNone ? next[from][0] : next[from][1]) = to;
    };
    for (int i = 0; i + 1 < count_.x; ++i) {
      for (int j = 0; j + 1 < count_.y; ++j) {
        const std::array<glm::ivec2, 4> corner{glm::ivec2(i, j), glm::ivec2(i + 1, j), glm::ivec2(i + 1, j + 1),
                                               glm::ivec2(i, j + 1)};
        std::vector<std::size_t> crossed;
        for (std::size_t k = 0; k < 4; ++k) {
          const glm::ivec2 p = corner[k], q = corner[(k + 1) % 4];
          if (layer.in[cell(p.x, p.y)] != layer.in[cell(q.x, q.y)]) crossed.push_back(point_on(p, q));
        }
        if (crossed.size() == 2) join(crossed[0], crossed[1]);
        // Two outlines cross this cell; each cuts off one unreachable corner.
        if (crossed.size() == 4) {
          const bool first = layer.in[cell(i, j)];
          join(crossed[first ? 0 : 3], crossed[first ? 1 : 0]);
          join(crossed[first ? 2 : 1], crossed[first ? 3 : 2]);
        }
      }
    }
    std::vector<dvec3> points(around.size());
    in_parallel(points.size(), [&](std::size_t k) { points[k] = border(around[k][0], around[k][1]); });
    std::vector<Chain> chains;
    std::vector<bool> used(points.size());
    const auto follow = [&](std::size_t start) {
      Chain chain{points[start]};
      used[start] = true;
      std::size_t at = start, from = kNone;
      while (true) {
        const std::size_t to = next[at][0] != from || next[at][1] == from ? next[at][0] : next[at][1];
        if (to == kNone || to == from) break;
        chain.push_back(points[to]);
        if (used[to]) break;
        used[to] = true;
        from = at;
        at = to;
      }
      chains.push_back(std::move(chain));
    };
    for (const bool ends : {true, false}) {
      for (std::size_t k = 0; k < points.size(); ++k)
        if (!used[k] && (!ends || next[k][1] == kNone)) follow(k);
    }
    return chains;
  }

  /// The lowest height at (a, b) to which the head can go without entering the ideal shape; empty if there is none.
  std::optional<double> lowest(double a, double b) const {
    const int i = static_cast<int>(std::lround((a - lo_.x) / grid_)),
              j = static_cast<int>(std::lround((b - lo_.y) / grid_));
    if (i < 0 || j < 0 || i >= count_.x || j >= count_.y) return std::nullopt;
    const Layer* from = nullptr;
    for (const Layer& layer : layers_)
      if (layer.in[cell(i, j)]) from = &layer;
    if (!from || !clear({a, b, from->height})) return std::nullopt;
    double height = from->height;
    while (height > bottom_ && clear({a, b, height - down_})) height -= down_;
    if (height <= bottom_) return std::nullopt;
    double below = height - down_;
    while (height - below > floor_of_column_) {
      const double middle = 0.5 * (height + below);
      (clear({a, b, middle}) ? height : below) = middle;
    }
    return height;
  }

  /// Positions across the floor of the passes along it, m: `options_.step` apart, and one in each slot between two of
  /// these.
  std::vector<double> floor_passes(bool along_x) const {
    const int columns = along_x ? count_.x : count_.y, rows = along_x ? count_.y : count_.x;
    std::vector<double> passes;
    std::vector<std::uint8_t> has(static_cast<std::size_t>(rows));  // 1: a pass is at this row of the grid
    for (double b = 0.5 * options_.step; b < rows * grid_; b += options_.step) {
      passes.push_back(b);
      has[static_cast<std::size_t>(std::min(std::lround(b / grid_), rows - 1L))] = 1;
    }
    const auto in = [&](const Layer& layer, int a, int b) { return layer.in[along_x ? cell(a, b) : cell(b, a)] != 0; };
    const auto reach = static_cast<int>(std::ceil(options_.step / grid_));
    const auto passed = [&](const Layer& layer, int a, int b) {
      for (int j = std::max(b - reach, 0); j <= std::min(b + reach, rows - 1); ++j) {
        if (!has[static_cast<std::size_t>(j)]) continue;
        for (int i = std::max(a - reach, 0); i <= std::min(a + reach, columns - 1); ++i)
          if (in(layer, i, j)) return true;
      }
      return false;
    };
    const auto missed = [&](int b) {
      for (const Layer& layer : layers_)
        for (int a = 0; a < columns; ++a)
          if (in(layer, a, b) && !passed(layer, a, b)) return true;
      return false;
    };
    for (int b = 0; b < rows; ++b)
      if (!has[static_cast<std::size_t>(b)] && missed(b))
        has[static_cast<std::size_t>(b)] = 1, passes.push_back(b * grid_);
    std::ranges::sort(passes);
    return passes;
  }

  /// Plans passes along the longer side of the floor. Returns the heights of the floor's flat parts.
  std::vector<double> floors() {
    struct Level {
      int columns = 0;
      double highest = 0;  // m, highest point of the floor
    };
    std::map<long, Level> levels;  // flat parts of the floor, sorted by height
    const glm::ivec2 extent = count_;
    const bool along_x = extent.x >= extent.y;
    const double length = (along_x ? extent.x : extent.y) * grid_;
    const std::vector<double> passes = floor_passes(along_x);
    std::vector<glm::dvec2> columns;
    for (const double b : passes)
      for (double a = 0; a <= length; a += grid_)
        columns.push_back(lo_ + (along_x ? glm::dvec2(a, b) : glm::dvec2(b, a)));
    std::vector<std::optional<double>> heights(columns.size());
    in_parallel(columns.size(), [&](std::size_t k) { heights[k] = lowest(columns[k].x, columns[k].y); });
    bool back = false;
    std::size_t column = 0;
    for (std::size_t pass = 0; pass < passes.size(); ++pass) {
      std::vector<Chain> pieces(1);
      for (double a = 0; a <= length; a += grid_, ++column) {
        const auto [x, y] = std::pair(columns[column].x, columns[column].y);
        const auto height = heights[column];
        Chain& piece = pieces.back();
        const bool joins = height && (piece.empty() || std::abs(*height - piece.back().z) < kSteep * grid_);
        if (!joins && !piece.empty()) pieces.emplace_back();
        if (!height) continue;
        pieces.back().push_back({x, y, *height});
        Level& level = levels[std::lround(*height / same_level_)];
        level.highest = level.columns++ > 0 ? std::max(level.highest, *height) : *height;
      }
      if (back) {
        std::reverse(pieces.begin(), pieces.end());
        for (Chain& piece : pieces) std::reverse(piece.begin(), piece.end());
      }
      const std::size_t before = strokes_.size();
      for (Chain& piece : pieces) take(piece, /*closed=*/false);
      if (strokes_.size() > before) back = !back;
    }
    std::vector<double> flat;
    for (const auto& [height, level] : levels)
      if (level.columns * grid_ * options_.step >
          std::max(kMinFlat, kFlatShare * kPi * tool_.radius() * tool_.radius()))
        flat.push_back(level.highest + on_line_);
    return flat;
  }

  const StrokeOptions options_;
  const double min_taken_;  // voxels; thinner tissue gets no stroke
  const double grid_ = options_.size * kGrid;
  const double down_ = options_.size * kDown;
  const double hop_ = options_.size * kHop;
  const double straight_ = options_.size * kStraight;
  const double ramp_ = options_.size * kRamp;
  const double on_line_ = options_.size * kOnLine;
  const double same_level_ = options_.size * kSameLevel;
  const double floor_of_column_ = options_.size * kFloorOfColumn;
  const session::Preparation& in_;
  const haptics::Tool& tool_;
  const bool coarse_ = tool_.coarse();
  const double bridged_ = options_.size * (coarse_ ? kCoarseBridged : kBridged);
  // Distance between two layers of strokes in the bulk, m.
  const double layer_ = (coarse_ ? kCoarseLayer : kLayer) * tool_.diameter;
  const session::DenseField& ideal_;
  session::DenseField left_;  // tissue that remains after the strokes planned so far
  dquat R_WT_;
  glm::dmat3 axes_;  // the axes u, v, w as columns
  double allowed_;   // voxels, largest depth to which the head may enter the target shape
  mutable std::atomic<std::size_t> entered_{SIZE_MAX};  // sphere of the head that last entered the target shape
  Tree head_tree_, shank_tree_;                         // points relative to the head's centre
  glm::dvec2 lo_{0};                                    // m along u, v: origin of the head positions' grid
  glm::ivec2 count_{0};
  double top_ = 0, bottom_ = 0;  // m along w: bounds of the head positions
  std::vector<Layer> layers_;
  std::vector<Stroke> strokes_;
  std::optional<dvec3> last_;  // end point of the last stroke
  bool bulk_ = true;           // true while strokes for the bulk of the tissue are added
};

}  // namespace

dquat toward(const dvec3& axis_W) {
  const dvec3 z(0, 0, 1), a = glm::normalize(axis_W);
  const dvec3 turn = glm::cross(z, a);
  const double s = glm::length(turn), c = glm::dot(z, a);
  if (s < 1e-12) return c > 0 ? dquat(1, 0, 0, 0) : dquat(0, 1, 0, 0);
  return glm::angleAxis(std::atan2(s, c), turn / s);
}

StrokePlan plan_strokes(const session::Preparation& in, const haptics::Tool& tool, const StrokeOptions& options) {
  return StrokePlanner(in, tool, options).plan();
}

void carve_strokes(haptics::TissueVolume& volume, const haptics::Tool& tool, const std::vector<Stroke>& strokes) {
  for (const Stroke& s : strokes) volume.carve(haptics::Sweep(tool, s.from, s.to, volume.frame()));
}

}  // namespace typodont
