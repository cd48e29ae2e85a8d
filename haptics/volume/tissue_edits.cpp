// Cuts, fillings, loose pieces, undo and redo.
#include <algorithm>
#include <array>
#include <atomic>
#include <cstring>
#include <vector>

#include "engine/base/voxels.h"
#include "haptics/cutting/inside_fraction.h"
#include "haptics/cutting/placed_head.h"
#include "haptics/cutting/voxel_stamp.h"
#include "haptics/solid.h"
#include "haptics/tissue_mesh.h"
#include "haptics/volume/emptied_piece.h"
#include "haptics/volume/leaf_key.h"
#include "haptics/volume/tissue_grids.h"
#include "haptics/work.h"

namespace typodont::haptics {

namespace {

/// Sums the volume of each tissue in leaves. Each voxel counts by the fraction of it that is inside the surface.
class LeafVolumes {
 public:
  void add(const DistanceGrid::Block& distance, const LabelGrid::Block& tissue) {
    constexpr int n = DistanceGrid::kSide, count = DistanceGrid::kSize;
    const float* const samples = distance.leaf ? distance.leaf->data() : nullptr;
    const std::int32_t* const labels = tissue.leaf ? tissue.leaf->data() : nullptr;
    const std::int32_t tile = samples ? 0 : inside_units(distance.tile);
    const std::int32_t label = labels ? labels[0] : tissue.tile;
    std::int32_t differ = 0;
    if (labels)
      for (int i = 1; i < count; ++i) differ |= labels[i] ^ label;
    if (differ != 0) {
      for (int i = 0; i < count; ++i) count_in(labels[i], samples ? inside_units(samples[i]) : tile);
      return;
    }
    // Most leaves have one tissue: labels need not be read.
    std::int64_t sum = samples ? 0 : std::int64_t{count} * tile;
    for (int row = 0; samples && row < count; row += n * n) {
      std::int32_t part = 0;
      for (int i = row; i < row + n * n; ++i) part += inside_units(samples[i]);
      sum += part;
    }
    count_in(label, sum);
  }
  /// Sums in m³. `voxel`: m.
  PerTissue sum(double voxel) const {
    PerTissue sum{};
    for (std::size_t i = 0; i < sum.size(); ++i)
      sum[i] = static_cast<double>(units_[i]) * kFractionUnit * voxel * voxel * voxel;
    return sum;
  }

 private:
  void count_in(std::int32_t label, std::int64_t units) {
    const auto which = static_cast<std::size_t>(shown_in(label));
    if (which < units_.size()) units_[which] += units;
  }
  std::array<std::int64_t, kTissueCount> units_{};
};

// initial-exec: with the default TLS model, each access from a shared library (libtypodont.so) calls a function.
[[gnu::tls_model("initial-exec")]] constinit thread_local std::uint64_t t_voxels_cut = 0;
void count_voxels(const glm::ivec3& box) noexcept {
  t_voxels_cut += static_cast<std::uint64_t>(box.x * box.y * box.z);
}

constexpr int kLeaf = Sweep::kLeaf;
static_assert(kLeaf == kLeafSide);

}  // namespace

std::uint64_t voxels_cut_by_this_thread() noexcept {
  return t_voxels_cut;
}

BrickBox bricks_around(const glm::ivec3& lo, const glm::ivec3& hi) {
  const auto brick = [](const glm::ivec3& voxel) {
    constexpr int n = FieldBrick::kCells;
    return glm::ivec3(floor_div(voxel.x, n), floor_div(voxel.y, n), floor_div(voxel.z, n));
  };
  return {brick(lo - 2), brick(hi + 1)};
}

void insert_bricks(const glm::ivec3& lo, const glm::ivec3& hi, KeySet& keys) {
  bricks_around(lo, hi).for_each([&](const glm::ivec3& brick) { keys.insert(brick); });
}

void TissueVolume::Impl::log_write(const glm::ivec3& lo, LeafFront::Place& leaf) {
  if (writes.empty() || leaf.logged == marked) return;
  leaf.logged = marked;
  // largest number of leaves in a list of written leaves; with more, copying the whole tissue patch is as fast
  constexpr std::size_t kMost = 2048;
  Written& written = writes.back();
  if (written.leaves.size() == kMost) written.listed = false;
  if (written.listed) written.leaves.push_back(lo);
}

void TissueVolume::Impl::mark_changed(const glm::ivec3& lo, const glm::ivec3& hi, bool listed) {
  if (lo.x > hi.x) return;
  if (!writes.empty()) {
    extend(writes.back().box, {lo, hi});
    writes.back().listed &= listed;
  }
  const BrickBox bricks = bricks_around(lo, hi);
  if (glm::all(glm::greaterThanEqual(bricks.lo, marked_lo)) && glm::all(glm::lessThanEqual(bricks.hi, marked_hi))) {
    return;
  }
  bricks.for_each([&](const glm::ivec3& brick) {
    changed.insert(brick);
    if (carved.insert(brick).second && in_stroke) strokes.back().carved.push_back(brick);
  });
  marked_lo = bricks.lo, marked_hi = bricks.hi;
}

std::uint64_t TissueVolume::Impl::first_mark() {
  // number of different marks (numbers of states) per volume; at one mark per microsecond, they last twelve days
  constexpr std::uint64_t kMarks = std::uint64_t{1} << 40;
  static std::atomic<std::uint64_t> volumes{0};
  return ++volumes * kMarks;
}

void TissueVolume::Impl::forget_writes() {
  writes.clear();
  ++marked;
  ++foreign_changes;
}

std::uint64_t TissueVolume::foreign_changes() const {
  return impl_->foreign_changes;
}

std::uint64_t TissueVolume::mark() {
  Impl& v = *impl_;
  // largest number of marks (numbered states of the volume) whose later writes are stored; each patch needs one mark
  constexpr std::size_t kMost = 32;
  if (!v.writes.empty() && v.writes.back().box.empty()) return v.marked;  // nothing was written since the last mark
  v.writes.emplace_back();
  if (v.writes.size() > kMost) v.writes.pop_front();
  return ++v.marked;
}

bool TissueVolume::written_since(std::uint64_t mark, Written& written) const {
  const Impl& v = *impl_;
  written = {};
  // Number of the newest marks (numbered states of the volume) whose later writes are all stored. Newest: v.marked.
  const std::uint64_t known = v.writes.size();
  if (mark > v.marked || mark + known <= v.marked) return false;
  for (std::uint64_t i = known - 1 - (v.marked - mark); i < known; ++i) {
    const Written& since = v.writes[i];
    if (!since.box.empty()) extend(written.box, since.box);
    written.listed &= since.listed;
    if (written.listed) written.leaves.insert(written.leaves.end(), since.leaves.begin(), since.leaves.end());
  }
  return true;
}

void TissueVolume::Impl::restore_labels(const TissueVolume& self, glm::ivec3 lo, glm::ivec3 hi) {
  if (lo.x > hi.x || filled.empty()) return;
  self.filled_box(lo - 1, hi + 1, lo, hi);
  if (lo.x > hi.x) return;
  const glm::ivec3 size = hi - lo + 3;  // the box with one more sample on every side
  const std::ptrdiff_t stride_y = size.z, stride_x = stride_y * size.y;
  std::vector<float> distances(static_cast<std::size_t>(stride_x * size.x));
  std::vector<Tissue> labels(distances.size());
  self.copy_for_patch(lo - 1, size, distances.data(), labels.data());
  const std::vector<Tissue> before = labels;
  const std::ptrdiff_t first = stride_x + stride_y + 1;
  if (!haptics::restore_labels(size - 2, distances.data() + first, labels.data() + first, stride_x, stride_y)) return;
  for (std::ptrdiff_t i = 0; i < static_cast<std::ptrdiff_t>(labels.size()); ++i) {
    const auto at = static_cast<std::size_t>(i);
    if (labels[at] == before[at]) continue;
    const glm::ivec3 p = lo - 1 + glm::ivec3(i / stride_x, i / stride_y % size.y, i % stride_y);
    LabelGrid::Block& block = tissue.block(leaf_key(p));
    if (in_stroke) StrokeKept::Labels::keep(strokes.back().tissue, leaf_key(p), block).changed = true;
    const int in_block = LabelGrid::Leaf::index(p);
    block.set(in_block, relabelled(block.value(in_block), labels[at]));
  }
}

/// Returns a leaf of distances for writing; null: air far from any surface. `kept`: the leaf's copy for undo.
LeafFront::Leaf* TissueVolume::Impl::leaf_to_cut(const glm::ivec3& key, LeafFront::Kept*& kept) {
  if (const auto& there = std::as_const(distance).block(key); !there.leaf && there.tile > 0) return nullptr;
  DistanceGrid::Block& block = distance.block(key);
  kept = in_stroke ? &StrokeKept::Distance::keep(strokes.back().distance, key, block) : nullptr;
  // A tile deep inside tissue is now near the surface, so that each of its samples must be stored.
  if (!block.leaf && kept) kept->changed = true;
  return &block.touch();
}

/// Called after a removal has written a leaf.
void TissueVolume::Impl::leaf_was_cut(LeafFront::Leaf& leaf, LeafFront::Kept* kept) {
  leaf.set_all_on();
  if (kept) kept->changed = true;
}

namespace {

/// Adds the samples lo..hi of a leaf to the box.
void add_to_box(const glm::ivec3& lo, const glm::ivec3& hi, VoxelBox& box) {
  count_voxels(hi - lo + 1);
  extend(box, {lo, hi});
}

}  // namespace

TissueVolume::Carved TissueVolume::carve(const Sweep& sweep) {
  Impl& v = *impl_;
  const glm::ivec3 first = leaf_key(sweep.lo()), last = leaf_key(sweep.hi());
  v.front.advance_to(sweep, first, last);
  const float path = v.front.path();
  v.due_leaves.clear(), v.due_places.clear();
  for (const LeafFront::DuePlace& due : v.front.due(first, last)) {
    LeafFront::Place& place = *due.place;
    const glm::ivec3 origin = due.key * kLeaf;
    if (!place.leaf) {
      place.leaf = v.leaf_to_cut(due.key, place.kept);
      if (!place.leaf) {
        *due.due = LeafFront::kNever;
        continue;
      }
    }
    // Created in its final place: copying an object whose members were just written would be slow.
    Sweep::Leaf& leaf = v.due_leaves.emplace_back();
    leaf.lo = origin, leaf.distance = place.leaf->data(), leaf.due = place.due.data();
    v.due_places.push_back(&due);
  }
  sweep.carve(v.due_leaves, path);
  Carved carved;
  const auto emptied = std::count_if(v.due_leaves.begin(), v.due_leaves.end(),
                                     [](const Sweep::Leaf& leaf) { return leaf.changed && leaf.emptied; });
  carved.blocks.reserve(static_cast<std::size_t>(emptied));
  for (std::size_t i = 0; i < v.due_leaves.size(); ++i) {
    const Sweep::Leaf& leaf = v.due_leaves[i];
    LeafFront::Place& place = *v.due_places[i]->place;
    *v.due_places[i]->due = *std::min_element(place.due.begin(), place.due.end());
    if (!leaf.changed) continue;
    if (!place.cut) v.leaf_was_cut(*place.leaf, place.kept);
    place.cut = true;
    v.log_write(leaf.lo, place);
    add_to_box(glm::max(leaf.lo, sweep.lo()), glm::min(leaf.lo + kLeaf - 1, sweep.hi()), carved.box);
    if (leaf.emptied) carved.blocks.push_back({leaf_key(leaf.lo), solid_bits(leaf.distance)});
  }
  // With fillings, the list of written leaves is not complete, because restore_labels() may write other leaves.
  v.mark_changed(carved.box.lo, carved.box.hi, v.filled.empty());
  v.restore_labels(*this, carved.box.lo, carved.box.hi);
  return carved;
}

template <class Removal>
TissueVolume::Carved TissueVolume::carve_leaves(const Removal& removal) {
  Impl& v = *impl_;
  v.front.forget();
  Carved carved;
  const glm::ivec3 first = leaf_key(removal.lo()), last = leaf_key(removal.hi());
  for_each_voxel_between(first, last, [&](const glm::ivec3& key) {
    const glm::ivec3 origin = key * kLeaf;
    LeafFront::Kept* kept = nullptr;
    auto* const leaf = v.leaf_to_cut(key, kept);
    if (!leaf) return;
    const glm::ivec3 lo = glm::max(origin, removal.lo()), hi = glm::min(origin + kLeaf - 1, removal.hi());
    const glm::ivec3 at = lo - origin;
    float* const samples = leaf->data() + (at.x * kLeaf + at.y) * kLeaf + at.z;
    if (!removal.carve(lo, hi - lo + 1, samples, kLeaf * kLeaf, kLeaf, nullptr, nullptr)) return;
    v.leaf_was_cut(*leaf, kept);
    add_to_box(lo, hi, carved.box);
    carved.blocks.push_back({key, solid_bits(leaf->data())});
  });
  v.mark_changed(carved.box.lo, carved.box.hi, false);
  v.restore_labels(*this, carved.box.lo, carved.box.hi);
  return carved;
}

TissueVolume::Carved TissueVolume::carve(const VoxelStamp& stamp) {
  return carve_leaves(stamp);
}

namespace {

/// Replaces distances. Has the member functions of a removal (for example Sweep), so the same templates accept it.
class Replacement {
 public:
  Replacement(const RasterBlock& block, float band) : block_(block), band_(band) {}
  const glm::ivec3& lo() const { return block_.lo; }
  glm::ivec3 hi() const { return block_.lo + block_.size - 1; }
  bool carve(const glm::ivec3& lo, const glm::ivec3& size, float* distance, std::size_t stride_x, std::size_t stride_y,
             const Tissue*, PerTissue*) const noexcept {
    bool changed = false;
    for_each_voxel(size, [&](int x, int y, int z) {
      const std::size_t from = voxel_index(lo - block_.lo + glm::ivec3(x, y, z), block_.size);
      float& to = distance[static_cast<std::size_t>(x) * stride_x + static_cast<std::size_t>(y) * stride_y +
                           static_cast<std::size_t>(z)];
      const float d = std::clamp(block_.distance[from], -band_, band_);
      changed = changed || to != d;
      to = d;
    });
    return changed;
  }

 private:
  const RasterBlock& block_;
  float band_;
};

}  // namespace

VoxelBox TissueVolume::replace(const RasterBlock& block) {
  ++impl_->foreign_changes;
  return carve_leaves(Replacement(block, static_cast<float>(band() / frame().voxel))).box;
}

template <class Filling>
VoxelBox TissueVolume::fill_leaves(const Filling& filling) {
  Impl& v = *impl_;
  v.front.forget();
  constexpr int n = DistanceGrid::kSide;
  glm::ivec3 changed_lo(INT_MAX), changed_hi(INT_MIN);
  StrokeKept* const stroke = v.stroke();
  Tissue tissue[n * n * n], before[n * n * n];
  for_each_voxel_between(leaf_key(filling.lo()), leaf_key(filling.hi()), [&](const glm::ivec3& key) {
    const glm::ivec3 origin = key * n;
    // a tile deep inside tissue, where nothing can be filled
    if (const auto& there = std::as_const(v.distance).block(key); !there.leaf && there.tile < 0) return;
    DistanceGrid::Block& block = v.distance.block(key);
    auto* kept = stroke ? &StrokeKept::Distance::keep(stroke->distance, key, block) : nullptr;
    if (kept && !block.leaf) kept->changed = true;
    DistanceGrid::Leaf& leaf = block.touch();
    copy_for_patch(origin, glm::ivec3(n), nullptr, tissue);
    std::copy_n(tissue, n * n * n, before);
    if (!filling.lower(origin, glm::ivec3(n), leaf.data(), tissue, n * n, n, nullptr)) return;
    const glm::ivec3 lo = glm::max(origin, filling.lo()), hi = glm::min(origin + n - 1, filling.hi());
    count_voxels(hi - lo + 1);
    leaf.set_all_on();
    if (kept) kept->changed = true;
    LabelGrid::Block& labels = v.tissue.block(key);
    if (stroke) StrokeKept::Labels::keep(stroke->tissue, key, labels).changed = true;
    for (int voxel = 0; voxel < n * n * n; ++voxel) {
      if (tissue[voxel] == before[voxel]) continue;
      labels.set(voxel, relabelled(labels.value(voxel), tissue[voxel]));
      v.filled.insert(key);
    }
    changed_lo = glm::min(changed_lo, lo);
    changed_hi = glm::max(changed_hi, hi);
  });
  v.mark_changed(changed_lo, changed_hi, false);
  v.restore_labels(*this, changed_lo, changed_hi);
  return {changed_lo, changed_hi};
}

VoxelBox TissueVolume::fill(const Fill& filling) {
  return fill_leaves(filling);
}

VoxelBox TissueVolume::fill(const PlacedHead& body) {
  ++impl_->foreign_changes;
  return fill_leaves(body);
}

PerTissue TissueVolume::remove_piece(const TissuePiece& piece) {
  Impl& v = *impl_;
  PerTissue volume{};
  if (piece.empty()) return volume;
  v.front.forget();
  v.forget_writes();
  constexpr int n = DistanceGrid::kSide;

  glm::ivec3 lo(INT_MAX), hi(INT_MIN);
  for (const BlockPart& part : piece) lo = glm::min(lo, part.key * n), hi = glm::max(hi, part.key * n + n - 1);
  lo -= kPieceMargin, hi += kPieceMargin;
  PieceBox box{hi - lo + 1, {}, {}};
  const std::size_t all = voxel_count(box.size);
  box.distance.resize(all);
  box.loose.resize(all);
  std::vector<Tissue> labels(all);
  copy(lo, box.size, box.distance.data(), labels.data());
  for (const BlockPart& part : piece) {
    for (int i = 0; i < n * n * n; ++i) {
      if (part.bits[static_cast<std::size_t>(i / (n * n))] >> (i % (n * n)) & 1) {
        box.loose[voxel_index(part.key * n + glm::ivec3(i / (n * n), i / n % n, i % n) - lo, box.size)] = 1;
      }
    }
  }
  const std::vector<float> after = without_piece(box);

  StrokeKept* const stroke = v.stroke();
  glm::ivec3 changed_lo(INT_MAX), changed_hi(INT_MIN);
  for_each_voxel_between(leaf_key(lo), leaf_key(hi), [&](const glm::ivec3& key) {
    DistanceGrid::Leaf* leaf = nullptr;
    const glm::ivec3 from = glm::max(lo, key * n), to = glm::min(hi, key * n + n - 1);
    for_each_voxel_between(from, to, [&](int x, int y, int z) {
      const std::size_t at = voxel_index(glm::ivec3(x, y, z) - lo, box.size);
      if (!(after[at] > box.distance[at])) return;
      if (!leaf) {
        DistanceGrid::Block& block = v.distance.block(key);
        if (stroke) StrokeKept::Distance::keep(stroke->distance, key, block).changed = true;
        leaf = &block.touch();
      }
      leaf->set(DistanceGrid::Leaf::index({x, y, z}), after[at]);
      volume[static_cast<std::size_t>(labels[at])] += fraction_inside(box.distance[at]) - fraction_inside(after[at]);
      changed_lo = glm::min(changed_lo, {x, y, z});
      changed_hi = glm::max(changed_hi, {x, y, z});
    });
    if (leaf) leaf->set_all_on();
  });
  v.mark_changed(changed_lo, changed_hi, false);
  v.restore_labels(*this, changed_lo, changed_hi);
  volume[0] = 0;
  for (double& fraction : volume) fraction *= v.frame.voxel * v.frame.voxel * v.frame.voxel;
  return volume;
}

bool TissueVolume::paint(Tissue label, const Solid& solid, std::uint8_t hardness, VoxelColor color) {
  Impl& v = *impl_;
  bool any = false;
  const VoxelBox tissue = v.tissue.box_on();
  dvec3 lo, hi;
  solid.bounds(lo, hi);
  const glm::ivec3 a = glm::max(glm::ivec3(glm::floor(glm::max(v.frame.to_voxels(lo), dvec3(-1e6)))), tissue.lo);
  const glm::ivec3 b = glm::min(glm::ivec3(glm::ceil(glm::min(v.frame.to_voxels(hi), dvec3(1e6)))), tissue.hi);
  for_each_voxel_between(a, b, [&](const glm::ivec3& voxel) {
    LabelGrid::Block& block = v.tissue.block(leaf_key(voxel));
    const int i = LabelGrid::Leaf::index(voxel);
    const std::int32_t was = block.value(i);
    if (shown_in(was) == Tissue::kAir || solid.distance(v.frame.to_world(dvec3(voxel))) > 0) return;
    if (StrokeKept* const stroke = v.stroke())
      StrokeKept::Labels::keep(stroke->tissue, leaf_key(voxel), block).changed = true;
    if (is_filled(label_in(was)))
      block.set(i, (was & ~std::int32_t{kShown}) | static_cast<std::int32_t>(label));
    else
      block.set(i, grid_value(label, hardness, color));
    any = true;
  });
  if (any) {
    v.forget_writes();
    ++v.paints;
    v.graded = v.graded || hardness != kOwnHardness;
    v.colored = v.colored || color != kTissueColor;
    insert_bricks(a, b, v.changed);
  }
  if (!v.mesh) return any;
  auto mesh = std::make_shared<TissueMesh>(*v.mesh);
  for (std::size_t i = 0; i < mesh->triangles.size(); ++i) {
    const glm::uvec3& t = mesh->triangles[i];
    const dvec3 center = (mesh->vertices[t.x] + mesh->vertices[t.y] + mesh->vertices[t.z]) / 3.0;
    if (solid.distance(center) > 0) continue;
    mesh->tissue[i] = label;
    any = true;
  }
  v.mesh = std::move(mesh);
  return any;
}

void TissueVolume::Impl::complete_stroke() {
  if (!in_stroke) return;
  in_stroke = false;
  front.forget();
  StrokeKept& stroke = strokes.back();
  const auto idle = [](const auto& entry) { return !entry.second.changed; };
  std::erase_if(stroke.distance, idle);
  std::erase_if(stroke.tissue, idle);
  if (stroke.distance.empty() && stroke.tissue.empty()) {
    strokes.pop_back();
    --done;
    return;
  }
  KeySet leaves;
  for (const auto& [key, kept] : stroke.distance) leaves.insert(key);
  for (const auto& [key, kept] : stroke.tissue) leaves.insert(key);
  KeySet bricks;
  LeafVolumes before, after;
  constexpr int n = DistanceGrid::kSide;
  DistanceGrid::Reader distances(distance);
  LabelGrid::Reader labels(tissue);
  for (const glm::ivec3& key : leaves) {
    insert_bricks(key * n, key * n + n - 1, bricks);
    const DistanceGrid::Block& distances_now = distances.block(key);
    const LabelGrid::Block& labels_now = labels.block(key);
    after.add(distances_now, labels_now);
    const auto* const distances_before = StrokeKept::Distance::before(stroke.distance, key);
    const auto* const labels_before = StrokeKept::Labels::before(stroke.tissue, key);
    before.add(distances_before ? *distances_before : distances_now, labels_before ? *labels_before : labels_now);
  }
  stroke.bricks.assign(bricks.begin(), bricks.end());
  const PerTissue was = before.sum(frame.voxel), is = after.sum(frame.voxel);
  for (std::size_t i = 0; i < was.size(); ++i) stroke.back[i] = was[i] - is[i];
  stroke.bytes = StrokeKept::Distance::bytes(stroke.distance) + StrokeKept::Labels::bytes(stroke.tissue) +
                 (stroke.carved.size() + stroke.bricks.size()) * sizeof(glm::ivec3);
}

void TissueVolume::Impl::exchange(StrokeKept& stroke, bool back) {
  front.forget();
  forget_writes();
  marked_lo = glm::ivec3(0), marked_hi = glm::ivec3(-1);
  StrokeKept::Distance::exchange(distance, stroke.distance);
  StrokeKept::Labels::exchange(tissue, stroke.tissue);
  for (std::size_t i = 0; i < taken_back.size(); ++i) taken_back[i] += back ? stroke.back[i] : -stroke.back[i];
  changed.insert(stroke.bricks.begin(), stroke.bricks.end());
  for (const glm::ivec3& brick : stroke.carved) {
    if (back)
      carved.erase(brick);
    else
      carved.insert(brick);
  }
}

void TissueVolume::begin_stroke() {
  Impl& v = *impl_;
  v.complete_stroke();
  v.front.forget();
  v.strokes.resize(v.done);
  v.strokes.emplace_back();
  ++v.done;
  v.in_stroke = true;
}

void TissueVolume::end_stroke() {
  impl_->complete_stroke();
}

const PerTissue& TissueVolume::taken_back() const {
  return impl_->taken_back;
}

bool TissueVolume::undo() {
  Impl& v = *impl_;
  v.complete_stroke();
  if (v.done == 0) return false;
  v.exchange(v.strokes[--v.done], true);
  return true;
}

bool TissueVolume::redo() {
  Impl& v = *impl_;
  // If there is no undone stroke, changes nothing; an unfinished stroke continues.
  if (v.done == v.strokes.size()) return false;
  v.exchange(v.strokes[v.done++], false);
  return true;
}

TissueVolume::Strokes TissueVolume::strokes() const {
  const Impl& v = *impl_;
  Strokes strokes{v.done, v.strokes.size() - v.done, 0};
  for (const StrokeKept& stroke : v.strokes) strokes.bytes += stroke.bytes;
  return strokes;
}

}  // namespace typodont::haptics
