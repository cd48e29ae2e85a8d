// The tissue in OpenVDB's grids. They hold voxels, not metres: OpenVDB refuses transforms under 15 µm in metres, and distances
// in voxels are what sampling and cutting work in.
#include "haptics/tissue_volume.h"

#include <openvdb/openvdb.h>

#include <algorithm>
#include <array>
#include <climits>
#include <cstring>
#include <optional>
#include <unordered_set>
#include <vector>

#include "engine/base/fnv.h"
#include "haptics/label.h"
#include "haptics/share.h"
#include "haptics/solid.h"
#include "haptics/volume/emptied_piece.h"
#include "haptics/volume/leaf_history.h"
#include "haptics/volume/volume_file.h"
#include "haptics/work.h"

namespace typodont::haptics {

namespace {

struct KeyHash {
  std::size_t operator()(const glm::ivec3& k) const {
    return static_cast<std::size_t>(k.x) * 73856093u ^ static_cast<std::size_t>(k.y) * 19349663u ^
           static_cast<std::size_t>(k.z) * 83492791u;
  }
};
using KeySet = std::unordered_set<glm::ivec3, KeyHash>;

openvdb::Coord coord(const glm::ivec3& v) { return {v.x, v.y, v.z}; }
glm::ivec3 vec(const openvdb::Coord& c) { return {c.x(), c.y(), c.z()}; }
int floor_div(int a, int b) { return a >= 0 ? a / b : -((-a + b - 1) / b); }

std::vector<glm::ivec3> sorted(const KeySet& keys) {
  std::vector<glm::ivec3> list(keys.begin(), keys.end());
  std::sort(list.begin(), list.end(), [](const glm::ivec3& a, const glm::ivec3& b) {
    return std::tie(a.x, a.y, a.z) < std::tie(b.x, b.y, b.z);
  });
  return list;
}

/// All bricks that read any of the samples in the inclusive box: a brick reads one sample beyond its cells on each side.
void insert_bricks(const glm::ivec3& lo, const glm::ivec3& hi, KeySet& keys) {
  constexpr int n = FieldBrick::kCells;
  for (int x = floor_div(lo.x - 2, n); x <= floor_div(hi.x + 1, n); ++x) {
    for (int y = floor_div(lo.y - 2, n); y <= floor_div(hi.y + 1, n); ++y) {
      for (int z = floor_div(lo.z - 2, n); z <= floor_div(hi.z + 1, n); ++z) keys.insert({x, y, z});
    }
  }
}

}  // namespace

/// All that one stroke changed, as it was before; once undone, as it was after.
struct StrokeKept {
  using Distance = LeafHistory<openvdb::FloatTree>;
  using Labels = LeafHistory<openvdb::Int32Tree>;
  Distance::Stroke distance;
  Labels::Stroke tissue;
  std::vector<glm::ivec3> carved;   // bricks first cut by this stroke
  // Once it is complete:
  std::vector<glm::ivec3> bricks;  // that are others when it is undone or brought again
  PerTissue back{};                // m³ that come back when it is undone
  std::size_t bytes = 0;
};

namespace {
/// What a value of the grid of labels shows.
Tissue shown_in(std::int32_t label) { return shown(static_cast<Tissue>(label)); }

/// What leaves hold of each tissue: every voxel by its share inside the surface.
class LeafVolumes {
 public:
  void add(const StrokeKept::Distance::Values& distance, const StrokeKept::Labels::Values& tissue) {
    constexpr int n = openvdb::FloatTree::LeafNodeType::DIM, count = n * n * n;
    const std::int32_t tile = distance.samples ? 0 : units_inside(distance.tile);
    const std::int32_t label = tissue.samples ? tissue.samples[0] : tissue.tile;
    std::int32_t differ = 0;
    if (tissue.samples)
      for (int i = 1; i < count; ++i) differ |= tissue.samples[i] ^ label;
    if (differ != 0) {
      for (int i = 0; i < count; ++i) count_in(tissue.samples[i], distance.samples ? units_inside(distance.samples[i]) : tile);
      return;
    }
    // One tissue, as in most: a sum without looking it up voxel by voxel.
    std::int64_t sum = distance.samples ? 0 : std::int64_t{count} * tile;
    for (int row = 0; distance.samples && row < count; row += n * n) {
      std::int32_t part = 0;
      for (int i = row; i < row + n * n; ++i) part += units_inside(distance.samples[i]);
      sum += part;
    }
    count_in(label, sum);
  }
  /// m³, of voxels that wide.
  PerTissue sum(double voxel) const {
    PerTissue sum{};
    for (std::size_t i = 0; i < sum.size(); ++i) sum[i] = static_cast<double>(units_[i]) * kShareUnit * voxel * voxel * voxel;
    return sum;
  }

 private:
  void count_in(std::int32_t label, std::int64_t units) {
    const auto which = static_cast<std::size_t>(shown_in(label));
    if (which < units_.size()) units_[which] += units;
  }
  std::array<std::int64_t, kTissueCount> units_{};
};

constinit thread_local std::uint64_t t_voxels_cut = 0;
void count_voxels(const glm::ivec3& box) noexcept {
  t_voxels_cut += static_cast<std::uint64_t>(box.x * box.y * box.z);
}
}  // namespace

struct TissueVolume::Impl {
  openvdb::FloatGrid::Ptr distance;  // voxels
  openvdb::Int32Grid::Ptr tissue;
  VoxelFrame frame;
  double band = 0;  // m
  bool exact_outside = true;
  KeySet changed;   // bricks since take_changed_bricks
  KeySet carved;    // bricks ever cut: distances outside the tissue are no longer true there
  KeySet filled;    // leaves, counted in leaves, that may hold labels of a filling: see label.h
  bool remembers = false;  // which leaves, counted in leaves, were written to …
  KeySet written;
  glm::ivec3 written_lo{INT_MAX}, written_hi{INT_MIN};  // … and between which voxels
  std::vector<StrokeKept> strokes;
  std::size_t done = 0;     // strokes in the tissue; those after it were undone
  bool in_stroke = false;   // the last one is still being made
  PerTissue taken_back{};   // m³ that came back by undoing, less what went again

  Impl() { openvdb::initialize(); }
  void make_grids(float band_voxels) {
    distance = openvdb::FloatGrid::create(band_voxels);
    tissue = openvdb::Int32Grid::create(0);
  }

  StrokeKept* stroke() { return in_stroke ? &strokes.back() : nullptr; }

  /// Drops leaves that were looked at only, and a stroke that changed nothing.
  void complete_stroke() {
    if (!in_stroke) return;
    in_stroke = false;
    StrokeKept& stroke = strokes.back();
    const auto idle = [](const auto& entry) { return !entry.second.changed; };
    std::erase_if(stroke.distance, idle);
    std::erase_if(stroke.tissue, idle);
    if (stroke.distance.empty() && stroke.tissue.empty()) {
      strokes.pop_back();
      --done;
      return;
    }
    std::vector<openvdb::Coord> leaves;
    for (const auto& [origin, kept] : stroke.distance) leaves.push_back(origin);
    for (const auto& [origin, kept] : stroke.tissue) {
      if (!stroke.distance.contains(origin)) leaves.push_back(origin);
    }
    KeySet bricks;
    LeafVolumes before, after;
    constexpr int n = openvdb::FloatTree::LeafNodeType::DIM;
    for (const openvdb::Coord& origin : leaves) {
      insert_bricks(vec(origin), vec(origin) + n - 1, bricks);
      const auto distances = StrokeKept::Distance::there(distance->tree(), origin);
      const auto labels = StrokeKept::Labels::there(tissue->tree(), origin);
      after.add(distances, labels);
      before.add(StrokeKept::Distance::before(stroke.distance, origin).value_or(distances),
                 StrokeKept::Labels::before(stroke.tissue, origin).value_or(labels));
    }
    stroke.bricks.assign(bricks.begin(), bricks.end());
    const PerTissue was = before.sum(frame.voxel), is = after.sum(frame.voxel);
    for (std::size_t i = 0; i < was.size(); ++i) stroke.back[i] = was[i] - is[i];
    stroke.bytes = StrokeKept::Distance::bytes(stroke.distance) + StrokeKept::Labels::bytes(stroke.tissue) +
                   (stroke.carved.size() + stroke.bricks.size()) * sizeof(glm::ivec3);
  }

  /// Bricks of a box that a cut or a filling has written to; lo > hi: it wrote nothing.
  void mark_changed(const glm::ivec3& lo, const glm::ivec3& hi) {
    if (lo.x > hi.x) return;
    if (remembers) written_lo = glm::min(written_lo, lo), written_hi = glm::max(written_hi, hi);
    KeySet bricks;
    insert_bricks(lo, hi, bricks);
    for (const glm::ivec3& brick : bricks) {
      changed.insert(brick);
      if (carved.insert(brick).second && in_stroke) strokes.back().carved.push_back(brick);
    }
  }

  /// See TissueVolume; of the samples between two, inclusive.
  void copy_every(int n, const Copied& box, const glm::ivec3& from, const glm::ivec3& to) const;

  // The two parts of labels, which files keep apart: see StoredVolume.
  openvdb::Int32Grid::Ptr take_before(openvdb::Int32Grid& labels) const;
  void put_before(const openvdb::Int32Grid& before);

  /// Where distances changed in that box: labels of fillings that are no longer there go.
  void restore_labels(const TissueVolume& self, glm::ivec3 lo, glm::ivec3 hi);

  void exchange(StrokeKept& stroke, bool back) {
    StrokeKept::Distance::exchange(distance->tree(), stroke.distance);
    StrokeKept::Labels::exchange(tissue->tree(), stroke.tissue);
    for (std::size_t i = 0; i < taken_back.size(); ++i) taken_back[i] += back ? stroke.back[i] : -stroke.back[i];
    changed.insert(stroke.bricks.begin(), stroke.bricks.end());
    for (const glm::ivec3& brick : stroke.carved) {
      if (back) carved.erase(brick);
      else carved.insert(brick);
    }
  }
};

TissueVolume::TissueVolume(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
TissueVolume::~TissueVolume() = default;
TissueVolume::TissueVolume(TissueVolume&&) noexcept = default;
TissueVolume& TissueVolume::operator=(TissueVolume&&) noexcept = default;

namespace {

/// The one label of a whole leaf of n³ voxels that lies beyond the band inside the tissue; nothing for any other.
std::optional<Tissue> uniform_inside(const DenseTissue& dense, const glm::ivec3& lo, const glm::ivec3& end, int n) {
  if (end != lo + n) return std::nullopt;
  const Tissue label = dense.tissue[dense.at(lo.x, lo.y, lo.z)];
  const auto deep = static_cast<float>(-dense.band);
  for (int x = lo.x; x < end.x; ++x) {
    for (int y = lo.y; y < end.y; ++y) {
      const std::size_t row = dense.at(x, y, lo.z);
      for (std::size_t i = row; i < row + static_cast<std::size_t>(n); ++i) {
        if (dense.distance[i] > deep || dense.tissue[i] != label) return std::nullopt;
      }
    }
  }
  return label;
}

}  // namespace

TissueVolume::TissueVolume(const DenseTissue& dense) : impl_(std::make_unique<Impl>()) {
  Impl& v = *impl_;
  v.frame = dense.frame;
  v.band = dense.band;
  v.exact_outside = dense.exact_outside;
  const auto band_voxels = static_cast<float>(dense.band / dense.frame.voxel);
  v.make_grids(band_voxels);

  // Leaf by leaf, so that voxels beyond the band never exist, not even for a moment.
  constexpr int n = openvdb::FloatTree::LeafNodeType::DIM;
  const auto to_voxels = static_cast<float>(1 / dense.frame.voxel), band = static_cast<float>(dense.band);
  auto distance = v.distance->getAccessor();
  auto tissue = v.tissue->getAccessor();
  for (int x0 = 0; x0 < dense.size.x; x0 += n) {
    for (int y0 = 0; y0 < dense.size.y; y0 += n) {
      for (int z0 = 0; z0 < dense.size.z; z0 += n) {
        const glm::ivec3 end = glm::min(glm::ivec3(x0 + n, y0 + n, z0 + n), dense.size);
        if (const auto label = uniform_inside(dense, {x0, y0, z0}, end, n)) {
          distance.addTile(1, openvdb::Coord(x0, y0, z0), -band_voxels, false);
          tissue.addTile(1, openvdb::Coord(x0, y0, z0), static_cast<int>(*label), *label != Tissue::kAir);
          continue;
        }
        for (int x = x0; x < end.x; ++x) {
          for (int y = y0; y < end.y; ++y) {
            for (int z = z0; z < end.z; ++z) {
              const std::size_t i = dense.at(x, y, z);
              const float d = dense.distance[i];
              const openvdb::Coord at(x, y, z);
              if (d < band && d > -band) {
                distance.setValue(at, d * to_voxels);
              } else if (d <= -band) {
                distance.setValueOff(at, -band_voxels);
              }
              if (dense.tissue[i] != Tissue::kAir) tissue.setValue(at, static_cast<int>(dense.tissue[i]));
            }
          }
        }
      }
    }
  }
  v.distance->pruneGrid();
  v.tissue->pruneGrid();
}

TissueVolume TissueVolume::load(const std::filesystem::path& file) {
  StoredVolume stored = read_volume(file);
  auto impl = std::make_unique<Impl>();
  impl->distance = std::move(stored.distance);
  impl->tissue = std::move(stored.tissue);
  impl->frame = stored.frame;
  impl->band = stored.band;
  impl->exact_outside = stored.exact_outside;
  if (stored.before) impl->put_before(*stored.before);
  return TissueVolume(std::move(impl));
}

openvdb::Int32Grid::Ptr TissueVolume::Impl::take_before(openvdb::Int32Grid& labels) const {
  openvdb::Int32Grid::Ptr before;
  for (const glm::ivec3& key : filled) {
    auto* leaf = labels.tree().probeLeaf(coord(key * static_cast<int>(openvdb::Int32Tree::LeafNodeType::DIM)));
    if (!leaf) continue;
    for (auto it = leaf->beginValueOn(); it; ++it) {
      const auto label = static_cast<Tissue>(*it);
      if (!is_filled(label)) continue;
      if (!before) before = openvdb::Int32Grid::create(0);
      before->tree().setValue(it.getCoord(), static_cast<int>(emptied(label)) + 1);
      it.setValue(static_cast<int>(shown(label)));
    }
  }
  return before;
}

void TissueVolume::Impl::put_before(const openvdb::Int32Grid& before) {
  constexpr int n = openvdb::Int32Tree::LeafNodeType::DIM;
  auto labels = tissue->getAccessor();
  for (auto it = before.cbeginValueOn(); it; ++it) {
    const openvdb::Coord at = it.getCoord();
    labels.setValue(at, static_cast<int>(haptics::filled(static_cast<Tissue>(*it - 1), shown_in(labels.getValue(at)))));
    filled.insert({floor_div(at.x(), n), floor_div(at.y(), n), floor_div(at.z(), n)});
  }
}

void TissueVolume::save(const std::filesystem::path& file) const {
  const Impl& v = *impl_;
  auto tissue = v.tissue->deepCopy();
  const auto before = v.take_before(*tissue);
  write_volume(file, {v.distance->deepCopy(), tissue, before, v.frame, v.band, v.exact_outside && v.carved.empty()});
}

const VoxelFrame& TissueVolume::frame() const { return impl_->frame; }
double TissueVolume::band() const { return impl_->band; }

bool TissueVolume::exact_outside() const { return impl_->exact_outside; }

void TissueVolume::cut_box(const glm::ivec3& lo, const glm::ivec3& hi, glm::ivec3& a_lo, glm::ivec3& a_hi) const {
  a_lo = glm::ivec3(INT_MAX), a_hi = glm::ivec3(INT_MIN);
  if (impl_->carved.empty()) return;
  KeySet touched;
  insert_bricks(lo, hi, touched);
  for (const glm::ivec3& key : touched) {
    if (!impl_->carved.contains(key)) continue;
    a_lo = glm::min(a_lo, key * FieldBrick::kCells - 1);
    a_hi = glm::max(a_hi, (key + 1) * FieldBrick::kCells + 1);
  }
}

void TissueVolume::bounds(glm::ivec3& lo, glm::ivec3& hi) const {
  const openvdb::CoordBBox box = impl_->distance->evalActiveVoxelBoundingBox();
  lo = vec(box.min());
  hi = vec(box.max());
  if (box.empty()) lo = {0, 0, 0}, hi = {-1, -1, -1};
}

namespace {

/// Leaf by leaf into a dense block of [lo, lo + size), z running quickest. What no leaf holds is its tile's, or
/// `background`, which the block is filled with already.
template <class Grid, class Out>
void copy_leaves(const Grid& grid, typename Grid::ValueType background, const glm::ivec3& lo, const glm::ivec3& size, Out* out) {
  auto accessor = grid.getConstAccessor();
  constexpr int n = Grid::TreeType::LeafNodeType::DIM;
  const glm::ivec3 end = lo + size;
  for (int x0 = floor_div(lo.x, n) * n; x0 < end.x; x0 += n) {
    for (int y0 = floor_div(lo.y, n) * n; y0 < end.y; y0 += n) {
      for (int z0 = floor_div(lo.z, n) * n; z0 < end.z; z0 += n) {
        const auto* leaf = accessor.probeConstLeaf(openvdb::Coord(x0, y0, z0));
        const auto tile = leaf ? background : accessor.getValue(openvdb::Coord(x0, y0, z0));
        if (!leaf && tile == background) continue;
        const auto* data = leaf ? leaf->buffer().data() : nullptr;
        for (int x = std::max(x0, lo.x); x < std::min(x0 + n, end.x); ++x) {
          for (int y = std::max(y0, lo.y); y < std::min(y0 + n, end.y); ++y) {
            Out* row = out + ((static_cast<std::size_t>(x - lo.x)) * size.y + (y - lo.y)) * size.z - lo.z;
            const auto* values = data ? data + ((x - x0) * n + (y - y0)) * n - z0 : nullptr;
            if (values && lo.z <= z0 && z0 + n <= end.z) {  // mostly; a length known beforehand is a few instructions
              for (int z = 0; z < n; ++z) row[z0 + z] = static_cast<Out>(values[z0 + z]);
              continue;
            }
            for (int z = std::max(z0, lo.z); z < std::min(z0 + n, end.z); ++z)
              row[z] = static_cast<Out>(values ? values[z] : tile);
          }
        }
      }
    }
  }
}

}  // namespace

void TissueVolume::copy(const glm::ivec3& lo, const glm::ivec3& size, float* distance, Tissue* tissue) const {
  copy_for_patch(lo, size, distance, tissue);
  if (!tissue || impl_->filled.empty()) return;
  const std::size_t count = static_cast<std::size_t>(size.x) * size.y * size.z;
  std::transform(tissue, tissue + count, tissue, shown);
}

void TissueVolume::filled_box(const glm::ivec3& lo, const glm::ivec3& hi, glm::ivec3& a_lo, glm::ivec3& a_hi) const {
  a_lo = glm::ivec3(INT_MAX), a_hi = glm::ivec3(INT_MIN);
  constexpr int n = openvdb::Int32Tree::LeafNodeType::DIM;
  for (const glm::ivec3& key : impl_->filled) {
    const glm::ivec3 from = glm::max(lo, key * n), to = glm::min(hi, key * n + n - 1);
    if (from.x > to.x || from.y > to.y || from.z > to.z) continue;
    a_lo = glm::min(a_lo, from), a_hi = glm::max(a_hi, to);
  }
}

void TissueVolume::Impl::restore_labels(const TissueVolume& self, glm::ivec3 lo, glm::ivec3 hi) {
  if (lo.x > hi.x || filled.empty()) return;
  self.filled_box(lo - 1, hi + 1, lo, hi);
  if (lo.x > hi.x) return;
  const glm::ivec3 size = hi - lo + 3;  // a sample more on every side
  const std::ptrdiff_t stride_y = size.z, stride_x = stride_y * size.y;
  std::vector<float> distances(static_cast<std::size_t>(stride_x * size.x));
  std::vector<Tissue> labels(distances.size());
  self.copy_for_patch(lo - 1, size, distances.data(), labels.data());
  const std::vector<Tissue> before = labels;
  const std::ptrdiff_t first = stride_x + stride_y + 1;
  if (!haptics::restore_labels(size - 2, distances.data() + first, labels.data() + first, stride_x, stride_y)) return;
  auto accessor = tissue->getAccessor();
  constexpr int mask = ~(openvdb::Int32Tree::LeafNodeType::DIM - 1);
  for (std::ptrdiff_t i = 0; i < static_cast<std::ptrdiff_t>(labels.size()); ++i) {
    const auto at = static_cast<std::size_t>(i);
    if (labels[at] == before[at]) continue;
    const openvdb::Coord p = coord(lo - 1 + glm::ivec3(i / stride_x, i / stride_y % size.y, i % stride_y));
    if (in_stroke) StrokeKept::Labels::keep(strokes.back().tissue, accessor, {p.x() & mask, p.y() & mask, p.z() & mask}).changed = true;
    if (remembers) written.insert({floor_div(p.x(), 8), floor_div(p.y(), 8), floor_div(p.z(), 8)});
    accessor.setValue(p, static_cast<int>(labels[at]));
  }
}

void TissueVolume::copy_for_patch(const glm::ivec3& lo, const glm::ivec3& size, float* distance, Tissue* tissue) const {
  const std::size_t count = static_cast<std::size_t>(size.x) * size.y * size.z;
  if (distance) {
    const float background = impl_->distance->background();
    std::fill_n(distance, count, background);
    copy_leaves(*impl_->distance, background, lo, size, distance);
  }
  if (!tissue) return;
  // Labels are bytes in messages and int32 in the grid.
  static_assert(sizeof(Tissue) == 1);
  std::memset(tissue, 0, count);
  copy_leaves(*impl_->tissue, 0, lo, size, tissue);
}

std::uint64_t voxels_cut_by_this_thread() noexcept {
  return t_voxels_cut;
}

void TissueVolume::copy_every(int n, const glm::ivec3& lo, const glm::ivec3& size, float* distance, Tissue* tissue) const {
  impl_->copy_every(n, {lo, size, distance, tissue}, lo, lo + size - 1);
}

void TissueVolume::remember_writes(bool wanted) {
  Impl& v = *impl_;
  v.remembers = wanted;
  v.written.clear();
  v.written_lo = glm::ivec3(INT_MAX), v.written_hi = glm::ivec3(INT_MIN);
}

void TissueVolume::copy_written(const Copied& box, int n, const Copied* every) {
  Impl& v = *impl_;
  constexpr int m = openvdb::FloatTree::LeafNodeType::DIM;
  auto distances = v.distance->getConstAccessor();
  auto labels = v.tissue->getConstAccessor();
  for (const glm::ivec3& key : v.written) {
    const glm::ivec3 first = key * m, lo = glm::max(first, box.lo), hi = glm::min(first + m, box.lo + box.size);
    const auto* leaf = distances.probeConstLeaf(coord(first));
    const auto* label = labels.probeConstLeaf(coord(first));
    const float distance = leaf ? 0 : distances.getValue(coord(first));
    const Tissue tile = label ? Tissue::kAir : static_cast<Tissue>(labels.getValue(coord(first)));
    for (int x = lo.x; x < hi.x; ++x) {
      for (int y = lo.y; y < hi.y; ++y) {
        const std::size_t row = (static_cast<std::size_t>(x - box.lo.x) * box.size.y + (y - box.lo.y)) * box.size.z;
        for (int z = lo.z; z < hi.z; ++z) {
          const std::size_t to = row + static_cast<std::size_t>(z - box.lo.z);
          const auto from = static_cast<openvdb::Index>(((x - first.x) * m + (y - first.y)) * m + (z - first.z));
          box.distance[to] = leaf ? leaf->getValue(from) : distance;
          box.tissue[to] = label ? static_cast<Tissue>(label->getValue(from)) : tile;
        }
      }
    }
  }
  if (every && v.written_lo.x <= v.written_hi.x) {
    // Whole bricks: in one that was never cut before deep samples change too.
    constexpr int cells = FieldBrick::kCells;
    const auto brick = [](int a) { return floor_div(a, cells); };
    const glm::ivec3 a = v.written_lo - 2, b = v.written_hi + 1;
    const glm::ivec3 from = glm::ivec3(brick(a.x), brick(a.y), brick(a.z)) * cells;
    const glm::ivec3 to = glm::ivec3(brick(b.x) + 1, brick(b.y) + 1, brick(b.z) + 1) * cells;
    const auto down = [n](const glm::ivec3& p) { return glm::ivec3(floor_div(p.x, n), floor_div(p.y, n), floor_div(p.z, n)); };
    v.copy_every(n, *every, glm::max(down(from), every->lo), glm::min(down(to) + 1, every->lo + every->size - 1));
  }
  remember_writes(v.remembers);
}

void TissueVolume::Impl::copy_every(int n, const Copied& box, const glm::ivec3& from, const glm::ivec3& to) const {
  const Impl& v = *this;
  auto distances = v.distance->getConstAccessor();
  auto labels = v.tissue->getConstAccessor();
  const float scale = 1.0f / static_cast<float>(n);
  constexpr int m = FieldBrick::kCells;
  glm::ivec3 brick(INT_MAX);
  bool carved = false;
  for (int x = from.x; x <= to.x; ++x) {
    for (int y = from.y; y <= to.y; ++y) {
      std::size_t i = (static_cast<std::size_t>(x - box.lo.x) * box.size.y + (y - box.lo.y)) * box.size.z +
                      static_cast<std::size_t>(from.z - box.lo.z);
      for (int z = from.z; z <= to.z; ++z, ++i) {
        const glm::ivec3 p = glm::ivec3(x, y, z) * n;
        float d = distances.getValue(coord(p));
        if (d < -Sweep::kMargin && !v.carved.empty()) {
          const glm::ivec3 in(floor_div(p.x, m), floor_div(p.y, m), floor_div(p.z, m));
          if (in != brick) brick = in, carved = v.carved.contains(in);
          if (carved) d = -Sweep::kMargin;
        }
        box.distance[i] = d * scale;
        box.tissue[i] = d < 3.0f * static_cast<float>(n) ? shown_in(labels.getValue(coord(p))) : Tissue::kAir;
      }
    }
  }
}

VoxelBox TissueVolume::carve(const Sweep& sweep) {
  Impl& v = *impl_;
  using Leaf = openvdb::FloatTree::LeafNodeType;
  constexpr int n = Leaf::DIM;
  auto accessor = v.distance->getAccessor();
  glm::ivec3 changed_lo(INT_MAX), changed_hi(INT_MIN);
  StrokeKept* const stroke = v.stroke();

  for (int x0 = floor_div(sweep.lo().x, n) * n; x0 <= sweep.hi().x; x0 += n) {
    for (int y0 = floor_div(sweep.lo().y, n) * n; y0 <= sweep.hi().y; y0 += n) {
      for (int z0 = floor_div(sweep.lo().z, n) * n; z0 <= sweep.hi().z; z0 += n) {
        const openvdb::Coord origin(x0, y0, z0);
        Leaf* leaf = accessor.probeLeaf(origin);
        if (!leaf && accessor.getValue(origin) > 0) continue;  // air, far from any surface
        auto* kept = stroke ? &StrokeKept::Distance::keep(stroke->distance, accessor, origin) : nullptr;
        if (!leaf) {
          leaf = accessor.touchLeaf(origin);  // solid, far inside: the cut brings it into the band
          if (kept) kept->changed = true;
        }
        const glm::ivec3 lo = glm::max(glm::ivec3(x0, y0, z0), sweep.lo());
        const glm::ivec3 hi = glm::min(glm::ivec3(x0, y0, z0) + n - 1, sweep.hi());
        const int first = ((lo.x - x0) * n + (lo.y - y0)) * n + (lo.z - z0);
        if (!sweep.raise(lo, hi - lo + 1, leaf->buffer().data() + first, n * n, n, nullptr, nullptr)) continue;
        count_voxels(hi - lo + 1);
        leaf->setValuesOn();
        if (kept) kept->changed = true;
        if (v.remembers) v.written.insert({x0 / n, y0 / n, z0 / n});
        changed_lo = glm::min(changed_lo, lo);
        changed_hi = glm::max(changed_hi, hi);
      }
    }
  }
  v.mark_changed(changed_lo, changed_hi);
  v.restore_labels(*this, changed_lo, changed_hi);
  return {changed_lo, changed_hi};
}

void TissueVolume::begin_stroke() {
  Impl& v = *impl_;
  v.complete_stroke();
  v.strokes.resize(v.done);
  v.strokes.emplace_back();
  ++v.done;
  v.in_stroke = true;
}

void TissueVolume::end_stroke() { impl_->complete_stroke(); }

const PerTissue& TissueVolume::taken_back() const { return impl_->taken_back; }

bool TissueVolume::undo() {
  Impl& v = *impl_;
  v.complete_stroke();
  if (v.done == 0) return false;
  v.exchange(v.strokes[--v.done], true);
  return true;
}

bool TissueVolume::redo() {
  Impl& v = *impl_;
  v.complete_stroke();
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

TissueVolume TissueVolume::clone() const {
  auto copy = std::make_unique<Impl>();
  const Impl& v = *impl_;
  copy->distance = v.distance->deepCopy();
  copy->tissue = v.tissue->deepCopy();
  copy->frame = v.frame, copy->band = v.band, copy->exact_outside = v.exact_outside;
  copy->carved = v.carved;
  copy->filled = v.filled;
  return TissueVolume(std::move(copy));
}

VoxelBox TissueVolume::fill(const Fill& filling) {
  Impl& v = *impl_;
  using Leaf = openvdb::FloatTree::LeafNodeType;
  constexpr int n = Leaf::DIM;
  auto distance = v.distance->getAccessor();
  auto labels = v.tissue->getAccessor();
  glm::ivec3 changed_lo(INT_MAX), changed_hi(INT_MIN);
  StrokeKept* const stroke = v.stroke();
  Tissue tissue[n * n * n], before[n * n * n];
  for (int x0 = floor_div(filling.lo().x, n) * n; x0 <= filling.hi().x; x0 += n) {
    for (int y0 = floor_div(filling.lo().y, n) * n; y0 <= filling.hi().y; y0 += n) {
      for (int z0 = floor_div(filling.lo().z, n) * n; z0 <= filling.hi().z; z0 += n) {
        const openvdb::Coord origin(x0, y0, z0);
        if (!distance.probeConstLeaf(origin) && distance.getValue(origin) < 0) continue;  // solid already, far inside
        auto* kept = stroke ? &StrokeKept::Distance::keep(stroke->distance, distance, origin) : nullptr;
        const bool was_tile = !distance.probeConstLeaf(origin);
        Leaf* leaf = distance.touchLeaf(origin);
        if (kept && was_tile) kept->changed = true;
        copy_for_patch({x0, y0, z0}, glm::ivec3(n), nullptr, tissue);
        std::copy_n(tissue, n * n * n, before);
        const glm::ivec3 lo = glm::max(glm::ivec3(x0, y0, z0), filling.lo());
        const glm::ivec3 hi = glm::min(glm::ivec3(x0, y0, z0) + n - 1, filling.hi());
        const int first = ((lo.x - x0) * n + (lo.y - y0)) * n + (lo.z - z0);
        if (!filling.lower(lo, hi - lo + 1, leaf->buffer().data() + first, tissue + first, n * n, n, nullptr)) continue;
        count_voxels(hi - lo + 1);
        leaf->setValuesOn();
        if (kept) kept->changed = true;
        if (v.remembers) v.written.insert({x0 / n, y0 / n, z0 / n});
        if (stroke) StrokeKept::Labels::keep(stroke->tissue, labels, origin).changed = true;
        for (int i = 0; i < n * n * n; ++i) {
          if (tissue[i] == before[i]) continue;
          labels.setValue(origin.offsetBy(i / (n * n), i / n % n, i % n), static_cast<int>(tissue[i]));
          v.filled.insert({x0 / n, y0 / n, z0 / n});
        }
        changed_lo = glm::min(changed_lo, lo);
        changed_hi = glm::max(changed_hi, hi);
      }
    }
  }
  v.mark_changed(changed_lo, changed_hi);
  v.restore_labels(*this, changed_lo, changed_hi);
  return {changed_lo, changed_hi};
}

void TissueVolume::solid_block(const glm::ivec3& key, SolidBits& bits) const {
  const openvdb::Coord origin = coord(key * static_cast<int>(openvdb::FloatTree::LeafNodeType::DIM));
  const auto& tree = impl_->distance->tree();
  const auto* leaf = tree.probeConstLeaf(origin);
  if (!leaf) {
    bits.fill(tree.getValue(origin) < 0 ? ~std::uint64_t{0} : 0);
    return;
  }
  const float* data = leaf->buffer().data();
  for (std::size_t x = 0; x < bits.size(); ++x) {
    std::uint64_t word = 0;
    for (int i = 0; i < 64; ++i) word |= static_cast<std::uint64_t>(data[x * 64 + static_cast<std::size_t>(i)] < 0) << i;
    bits[x] = word;
  }
}

PerTissue TissueVolume::take_out(const TissuePiece& piece) {
  Impl& v = *impl_;
  PerTissue volume{};
  if (piece.empty()) return volume;
  using Leaf = openvdb::FloatTree::LeafNodeType;
  constexpr int n = Leaf::DIM;

  glm::ivec3 lo(INT_MAX), hi(INT_MIN);
  for (const BlockPart& part : piece) lo = glm::min(lo, part.key * n), hi = glm::max(hi, part.key * n + n - 1);
  lo -= kPieceMargin, hi += kPieceMargin;
  PieceBox box{hi - lo + 1, {}, {}};
  const std::size_t all = box.at({box.size.x, 0, 0});
  box.distance.resize(all);
  box.loose.resize(all);
  std::vector<Tissue> labels(all);
  copy(lo, box.size, box.distance.data(), labels.data());
  for (const BlockPart& part : piece) {
    for (int i = 0; i < n * n * n; ++i) {
      if (part.bits[static_cast<std::size_t>(i / (n * n))] >> (i % (n * n)) & 1) {
        box.loose[box.at(part.key * n + glm::ivec3(i / (n * n), i / n % n, i % n) - lo)] = 1;
      }
    }
  }
  const std::vector<float> after = without_piece(box);

  auto accessor = v.distance->getAccessor();
  StrokeKept* const stroke = v.stroke();
  glm::ivec3 changed_lo(INT_MAX), changed_hi(INT_MIN);
  for (int x0 = floor_div(lo.x, n) * n; x0 <= hi.x; x0 += n) {
    for (int y0 = floor_div(lo.y, n) * n; y0 <= hi.y; y0 += n) {
      for (int z0 = floor_div(lo.z, n) * n; z0 <= hi.z; z0 += n) {
        const openvdb::Coord origin(x0, y0, z0);
        const glm::ivec3 from = glm::max(lo, {x0, y0, z0}), to = glm::min(hi, glm::ivec3(x0, y0, z0) + n - 1);
        Leaf* leaf = nullptr;
        for (int x = from.x; x <= to.x; ++x) {
          for (int y = from.y; y <= to.y; ++y) {
            for (int z = from.z; z <= to.z; ++z) {
              const std::size_t i = box.at(glm::ivec3(x, y, z) - lo);
              if (!(after[i] > box.distance[i])) continue;
              if (!leaf) {
                auto* kept = stroke ? &StrokeKept::Distance::keep(stroke->distance, accessor, origin) : nullptr;
                if (kept) kept->changed = true;
                leaf = accessor.touchLeaf(origin);
              }
              leaf->setValueOn(leaf->coordToOffset({x, y, z}), after[i]);
              volume[static_cast<std::size_t>(labels[i])] += share_inside(box.distance[i]) - share_inside(after[i]);
              changed_lo = glm::min(changed_lo, {x, y, z});
              changed_hi = glm::max(changed_hi, {x, y, z});
            }
          }
        }
        if (leaf) leaf->setValuesOn();
      }
    }
  }
  v.mark_changed(changed_lo, changed_hi);
  v.restore_labels(*this, changed_lo, changed_hi);
  volume[0] = 0;
  for (double& share : volume) share *= v.frame.voxel * v.frame.voxel * v.frame.voxel;
  return volume;
}

void TissueVolume::paint(Tissue label, const Solid& solid) {
  Impl& v = *impl_;
  const openvdb::CoordBBox tissue = v.tissue->evalActiveVoxelBoundingBox();
  dvec3 lo, hi;
  solid.bounds(lo, hi);
  const glm::ivec3 a = glm::max(glm::ivec3(glm::floor(glm::max(v.frame.to_voxels(lo), dvec3(-1e6)))), vec(tissue.min()));
  const glm::ivec3 b = glm::min(glm::ivec3(glm::ceil(glm::min(v.frame.to_voxels(hi), dvec3(1e6)))), vec(tissue.max()));
  auto accessor = v.tissue->getAccessor();
  for (int x = a.x; x <= b.x; ++x) {
    for (int y = a.y; y <= b.y; ++y) {
      for (int z = a.z; z <= b.z; ++z) {
        const openvdb::Coord at(x, y, z);
        const std::int32_t was = accessor.getValue(at);
        if (shown_in(was) == Tissue::kAir || solid.distance(v.frame.to_world(dvec3(x, y, z))) > 0) continue;
        if (StrokeKept* const stroke = v.stroke()) {
          constexpr int mask = ~(openvdb::Int32Tree::LeafNodeType::DIM - 1);
          StrokeKept::Labels::keep(stroke->tissue, accessor, {x & mask, y & mask, z & mask}).changed = true;
        }
        accessor.setValue(at, (was & ~kShown) | static_cast<int>(label));
      }
    }
  }
  if (a.x <= b.x && a.y <= b.y && a.z <= b.z) insert_bricks(a, b, v.changed);
}

std::vector<glm::ivec3> TissueVolume::surface_bricks() const {
  // A leaf with a sample on each side, or one next to a sample of the other sign, holds surface: |distance| < 2 is both.
  KeySet keys;
  for (auto leaf = impl_->distance->tree().cbeginLeaf(); leaf; ++leaf) {
    glm::ivec3 lo(INT_MAX), hi(INT_MIN);
    for (auto it = leaf->cbeginValueOn(); it; ++it) {
      if (std::abs(*it) > 2) continue;
      const glm::ivec3 at = vec(it.getCoord());
      lo = glm::min(lo, at);
      hi = glm::max(hi, at);
    }
    if (lo.x <= hi.x) insert_bricks(lo, hi, keys);
  }
  return sorted(keys);
}

std::vector<glm::ivec3> TissueVolume::take_changed_bricks() {
  const auto list = sorted(impl_->changed);
  impl_->changed.clear();
  return list;
}

void TissueVolume::read_brick(const glm::ivec3& key, FieldBrick& brick) const {
  brick.key = key;
  copy(key * FieldBrick::kCells - 1, glm::ivec3(FieldBrick::kSamples), brick.distance.data(), brick.tissue.data());
}

PerTissue TissueVolume::volumes() const {
  PerTissue volumes{};
  auto tissue = impl_->tissue->getConstAccessor();
  const double voxel3 = impl_->frame.voxel * impl_->frame.voxel * impl_->frame.voxel;
  for (auto it = impl_->distance->cbeginValueAll(); it; ++it) {
    const double share = share_inside(*it);
    if (share == 0) continue;
    if (it.isVoxelValue()) {
      volumes[static_cast<std::size_t>(shown_in(tissue.getValue(it.getCoord())))] += share * voxel3;
      continue;
    }
    openvdb::CoordBBox box;
    it.getBoundingBox(box);
    for (auto c = box.begin(); c; ++c) volumes[static_cast<std::size_t>(shown_in(tissue.getValue(*c)))] += share * voxel3;
  }
  volumes[0] = 0;
  return volumes;
}

std::uint64_t TissueVolume::hash() const {
  Fnv1a hash;
  auto tissue = impl_->tissue->getConstAccessor();
  for (auto leaf = impl_->distance->tree().cbeginLeaf(); leaf; ++leaf) {
    const openvdb::Coord origin = leaf->origin();
    hash.bytes(origin.data(), 3 * sizeof(int));
    hash.bytes(leaf->buffer().data(), sizeof(float) * leaf->buffer().size());
    for (auto it = leaf->cbeginValueOn(); it; ++it) {
      const int label = tissue.getValue(it.getCoord());
      hash.bytes(&label, sizeof label);
    }
  }
  return hash.value;
}

}  // namespace typodont::haptics
