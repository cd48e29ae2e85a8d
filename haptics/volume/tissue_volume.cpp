// The grids store lengths in voxels: OpenVDB refuses voxels below 15 µm, and sampling and cutting compute in voxels.
#include "haptics/tissue_volume.h"

#include <linux/mman.h>
#include <sys/mman.h>

#include <algorithm>
#include <bit>
#include <climits>
#include <cmath>
#include <cstring>
#include <iterator>
#include <optional>
#include <type_traits>
#include <unordered_map>
#include <utility>
#include <vector>

#include "engine/base/dispatch.h"
#include "engine/base/fnv.h"
#include "engine/base/voxels.h"
#include "haptics/cutting/inside_fraction.h"
#include "haptics/cutting/lanes.h"
#include "haptics/volume/leaf_rows.h"
#include "haptics/volume/tissue_grids.h"
#include "haptics/volume/volume_file.h"

namespace typodont::haptics {

namespace {

std::vector<glm::ivec3> sorted(const KeySet& keys) {
  std::vector<glm::ivec3> list(keys.begin(), keys.end());
  std::ranges::sort(list, LessByAxes{});
  return list;
}

}  // namespace

TissueVolume::Impl::~Impl() {
  // OpenVDB frees nodes on several threads, which needs memory, and aborts if there is none. So all nodes are freed
  // here first, on one thread.
  if (distance) distance->tree().root().clear();
  if (tissue) tissue->tree().root().clear();
}

TissueVolume::TissueVolume(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
TissueVolume::~TissueVolume() = default;
TissueVolume::TissueVolume(TissueVolume&&) noexcept = default;
TissueVolume& TissueVolume::operator=(TissueVolume&&) noexcept = default;

namespace {

/// Returns the value that the label grid stores for voxel `i` of `dense`.
std::int32_t value_at(const DenseTissue& dense, std::size_t i) {
  return grid_value(dense.tissue[i], dense.hardness.empty() ? kOwnHardness : dense.hardness[i],
                    dense.color.empty() ? kTissueColor : dense.color[i]);
}

/// Label grid's value of n³ voxels, if all have the same value and are deeper than the stored band; otherwise nullopt.
std::optional<std::int32_t> uniform_inside(const DenseTissue& dense, const glm::ivec3& lo, const glm::ivec3& end,
                                           int n) {
  if (end != lo + n) return std::nullopt;
  const std::int32_t value = value_at(dense, dense.at(lo.x, lo.y, lo.z));
  const auto deep = static_cast<float>(-dense.band);
  for (int x = lo.x; x < end.x; ++x) {
    for (int y = lo.y; y < end.y; ++y) {
      const std::size_t row = dense.at(x, y, lo.z);
      for (std::size_t i = row; i < row + static_cast<std::size_t>(n); ++i) {
        if (dense.distance[i] > deep || value_at(dense, i) != value) return std::nullopt;
      }
    }
  }
  return value;
}

constexpr std::uintptr_t kHugePage = 2 << 20;  // bytes, size of a huge memory page

/// Adds the bytes of leaves in each huge page (by its number) to `bytes`.
template <class Tree>
void count_leaves(const Tree& tree, std::unordered_map<std::uintptr_t, std::size_t>& bytes) {
  for (auto leaf = tree.cbeginLeaf(); leaf; ++leaf) {
    const auto at = reinterpret_cast<std::uintptr_t>(leaf->buffer().data());
    bytes[at / kHugePage] += sizeof(typename Tree::ValueType) * leaf->buffer().size();
  }
}

/// Requests huge memory pages. With pages of 4 kB, address translation takes up to a fifth of the time for copying.
/// Results do not depend on the page size.
void store_in_huge_pages(const openvdb::FloatTree& distances, const openvdb::Int32Tree& labels) {
  std::unordered_map<std::uintptr_t, std::size_t> bytes;
  count_leaves(distances, bytes);
  count_leaves(labels, bytes);
  for (const auto& [page, of_leaves] : bytes) {
    if (of_leaves >= kHugePage / 2) madvise(reinterpret_cast<void*>(page * kHugePage), kHugePage, MADV_COLLAPSE);
  }
}

}  // namespace

TissueVolume::TissueVolume(const DenseTissue& dense) : impl_(std::make_unique<Impl>()) {
  Impl& v = *impl_;
  v.frame = dense.frame;
  v.band = dense.band;
  v.exact_outside = dense.exact_outside;
  v.place = dense.place;
  v.graded = std::ranges::any_of(dense.hardness, [](std::uint8_t hardness) { return hardness != kOwnHardness; });
  v.colored = std::ranges::any_of(dense.color, [](VoxelColor color) { return color != kTissueColor; });
  const auto band_voxels = static_cast<float>(dense.band / dense.frame.voxel);
  v.make_grids(band_voxels);

  // Stores leaf by leaf, which saves memory where no distances are stored.
  constexpr int n = openvdb::FloatTree::LeafNodeType::DIM;
  const auto to_voxels = static_cast<float>(1 / dense.frame.voxel), band = static_cast<float>(dense.band);
  auto distance = v.distance->getAccessor();
  auto tissue = v.tissue->getAccessor();
  for (int x0 = 0; x0 < dense.size.x; x0 += n) {
    for (int y0 = 0; y0 < dense.size.y; y0 += n) {
      for (int z0 = 0; z0 < dense.size.z; z0 += n) {
        const glm::ivec3 end = glm::min(glm::ivec3(x0 + n, y0 + n, z0 + n), dense.size);
        if (const auto value = uniform_inside(dense, {x0, y0, z0}, end, n)) {
          distance.addTile(1, openvdb::Coord(x0, y0, z0), -band_voxels, false);
          tissue.addTile(1, openvdb::Coord(x0, y0, z0), *value, label_in(*value) != Tissue::kAir);
          continue;
        }
        // leaves of both trees, created when their first voxel is stored
        openvdb::FloatTree::LeafNodeType* distances = nullptr;
        openvdb::Int32Tree::LeafNodeType* labels = nullptr;
        const openvdb::Coord first(x0, y0, z0);
        for (int x = x0; x < end.x; ++x) {
          for (int y = y0; y < end.y; ++y) {
            for (int z = z0; z < end.z; ++z) {
              const std::size_t i = dense.at(x, y, z);
              const openvdb::Index in_leaf = openvdb::FloatTree::LeafNodeType::coordToOffset({x, y, z});
              if (const float d = dense.distance[i]; d < band) {
                if (!distances) distances = distance.touchLeaf(first);
                if (d > -band)
                  distances->setValueOn(in_leaf, d * to_voxels);
                else
                  distances->setValueOff(in_leaf, -band_voxels);
              }
              if (dense.tissue[i] != Tissue::kAir) {
                if (!labels) labels = tissue.touchLeaf(first);
                labels->setValueOn(in_leaf, value_at(dense, i));
              }
            }
          }
        }
      }
    }
  }
  v.distance->pruneGrid();
  v.tissue->pruneGrid();
  store_in_huge_pages(v.distance->tree(), v.tissue->tree());
}

TissueVolume TissueVolume::load(const std::filesystem::path& file) {
  StoredVolume stored = read_volume(file);
  auto impl = std::make_unique<Impl>();
  impl->distance = std::move(stored.distance);
  impl->tissue = std::move(stored.tissue);
  impl->frame = stored.frame;
  impl->band = stored.band;
  impl->exact_outside = stored.exact_outside;
  impl->place = stored.place;
  if (stored.before) impl->put_before(*stored.before);
  impl->graded = stored.hardness && impl->put(Impl::kHardnessPart, *stored.hardness);
  impl->colored = stored.color && impl->put(Impl::kColorPart, *stored.color);
  store_in_huge_pages(impl->distance->tree(), impl->tissue->tree());
  return TissueVolume(std::move(impl));
}

const TissueVolume::Impl::Part TissueVolume::Impl::kHardnessPart{
    kOwnHardness, [](std::int32_t value) -> std::int32_t { return hardness_kept_in(value); },
    [](std::int32_t value, std::int32_t hardness) {
      return grid_value(label_in(value), static_cast<std::uint8_t>(hardness), color_kept_in(value));
    }};

const TissueVolume::Impl::Part TissueVolume::Impl::kColorPart{
    kNoFileColor,
    [](std::int32_t value) {
      const VoxelColor color = color_kept_in(value);
      if (color == kTissueColor) return kNoFileColor;
      const glm::ivec3 bytes(glm::round(255.0 * srgb_of(color)));
      return bytes.x << 16 | bytes.y << 8 | bytes.z;
    },
    [](std::int32_t value, std::int32_t color) {
      const dvec3 srgb = dvec3(color >> 16, color >> 8 & 255, color & 255) / 255.0;
      return grid_value(label_in(value), hardness_kept_in(value),
                        color == kNoFileColor ? kTissueColor : voxel_color(srgb));
    }};

openvdb::Int32Grid::Ptr TissueVolume::Impl::take(const Part& part, openvdb::Int32Grid& labels) {
  openvdb::Int32Grid::Ptr taken;
  for (auto it = labels.beginValueOn(); it; ++it) {
    const std::int32_t value = *it, own = part.get(value);
    if (own == part.usual) continue;
    if (!taken) taken = openvdb::Int32Grid::create(part.usual);
    if (it.isVoxelValue()) {
      taken->tree().setValue(it.getCoord(), own);
    } else {
      openvdb::CoordBBox box;
      it.getBoundingBox(box);
      taken->sparseFill(box, own, true);
    }
    it.setValue(part.set(value, part.usual));
  }
  return taken;
}

/// Tiles of the part's grid may have any size, so all voxels and tiles of the labels are visited.
bool TissueVolume::Impl::put(const Part& part, const openvdb::Int32Grid& values) {
  constexpr int n = openvdb::Int32Tree::LeafNodeType::DIM;
  auto of = values.getConstAccessor();
  bool unusual = false;
  const auto with = [&](std::int32_t value, std::int32_t own) {
    unusual |= own != part.usual;
    return part.set(value, own);
  };
  std::vector<std::pair<openvdb::CoordBBox, std::int32_t>> tiles;
  for (auto it = tissue->beginValueOn(); it; ++it) {
    if (it.isVoxelValue()) {
      it.setValue(with(*it, of.getValue(it.getCoord())));
      continue;
    }
    openvdb::CoordBBox box;
    it.getBoundingBox(box);
    tiles.emplace_back(box, *it);
  }
  auto labels = tissue->getAccessor();
  for (const auto& [box, value] : tiles) {
    for (int x = box.min().x(); x <= box.max().x(); x += n) {
      for (int y = box.min().y(); y <= box.max().y(); y += n) {
        for (int z = box.min().z(); z <= box.max().z(); z += n) {
          const openvdb::Coord origin(x, y, z);
          if (const auto* leaf = of.probeConstLeaf(origin)) {
            auto* to = labels.touchLeaf(origin);
            for (openvdb::Index i = 0; i < leaf->SIZE; ++i) to->setValueOn(i, with(value, leaf->getValue(i)));
          } else if (const std::int32_t own = of.getValue(origin); own != part.usual) {
            labels.addTile(1, origin, with(value, own), true);
          }
        }
      }
    }
  }
  tissue->pruneGrid();
  return unusual;
}

openvdb::Int32Grid::Ptr TissueVolume::Impl::take_before(openvdb::Int32Grid& labels) const {
  openvdb::Int32Grid::Ptr before;
  for (const glm::ivec3& key : filled) {
    auto* leaf = labels.tree().probeLeaf(coord(key * static_cast<int>(openvdb::Int32Tree::LeafNodeType::DIM)));
    if (!leaf) continue;
    for (auto it = leaf->beginValueOn(); it; ++it) {
      const Tissue label = label_in(*it);
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
  const auto hardness = v.graded ? Impl::take(Impl::kHardnessPart, *tissue) : nullptr;
  const auto color = v.colored ? Impl::take(Impl::kColorPart, *tissue) : nullptr;
  const auto before = v.take_before(*tissue);
  write_volume(file, {v.distance->deepCopy(), tissue, before, hardness, color, v.frame, v.band,
                      v.exact_outside && v.carved.empty(), v.place});
}

const VoxelFrame& TissueVolume::frame() const {
  return impl_->frame;
}
double TissueVolume::band() const {
  return impl_->band;
}

bool TissueVolume::exact_outside() const {
  return impl_->exact_outside;
}
const FilePlace& TissueVolume::place() const {
  return impl_->place;
}
void TissueVolume::set_place(const FilePlace& place) {
  impl_->place = place;
}

std::uint64_t TissueVolume::paints() const {
  return impl_->paints;
}

bool TissueVolume::graded() const {
  return impl_->graded;
}
bool TissueVolume::colored() const {
  return impl_->colored;
}

const std::shared_ptr<const TissueMesh>& TissueVolume::mesh() const {
  return impl_->mesh;
}
void TissueVolume::set_mesh(std::shared_ptr<const TissueMesh> mesh) {
  impl_->mesh = std::move(mesh);
}

const std::shared_ptr<const NaturalSurface>& TissueVolume::natural_surface() const {
  return impl_->natural;
}
void TissueVolume::keep_natural_surface() {
  impl_->natural = std::make_shared<const NaturalSurface>(*this);
}
void TissueVolume::set_natural_surface(std::shared_ptr<const NaturalSurface> natural) {
  impl_->natural = std::move(natural);
}

void TissueVolume::cut_box(const glm::ivec3& lo, const glm::ivec3& hi, glm::ivec3& a_lo, glm::ivec3& a_hi) const {
  a_lo = glm::ivec3(INT_MAX), a_hi = glm::ivec3(INT_MIN);
  if (impl_->carved.empty()) return;
  bricks_around(lo, hi).for_each([&](const glm::ivec3& key) {
    if (!impl_->carved.contains(key)) return;
    a_lo = glm::min(a_lo, key * FieldBrick::kCells - 1);
    a_hi = glm::max(a_hi, (key + 1) * FieldBrick::kCells + 1);
  });
}

void TissueVolume::bounds(glm::ivec3& lo, glm::ivec3& hi) const {
  const openvdb::CoordBBox box = impl_->distance->evalActiveVoxelBoundingBox();
  lo = vec(box.min());
  hi = vec(box.max());
  if (box.empty()) lo = {0, 0, 0}, hi = {-1, -1, -1};
}

namespace {

/// Converts a leaf's row in a local array, vectorised.
template <class Value, class Out, class Convert>
void copy_leaf_row(const Value* from, Out* to, const Convert& converted) {
  constexpr int n = openvdb::FloatTree::LeafNodeType::DIM;
  if constexpr (std::is_same_v<Value, Out>) {  // distances are not converted
    std::memcpy(to, from, n * sizeof(Out));
  } else {
    Out row[n];
    for (int z = 0; z < n; ++z) row[z] = converted(from[z]);
    std::memcpy(to, row, sizeof row);
  }
}

/// Copies `part` of a grid into [lo, lo + size), z is the fastest index, converted by `converted`. Without a leaf, the
/// tile's value is used.
template <class Grid, class Out, class Convert>
void copy_box(const Grid& grid, const glm::ivec3& lo, const glm::ivec3& size, const VoxelBox& part, Out* out,
              const Convert& converted) {
  constexpr int n = Grid::TreeType::LeafNodeType::DIM;
  const std::ptrdiff_t stride_y = size.z, stride_x = stride_y * size.y;
  auto accessor = grid.getConstAccessor();
  const auto first = [](int v) { return floor_div(v, n) * n; };
  for (int x0 = first(part.lo.x); x0 <= part.hi.x; x0 += n) {
    for (int y0 = first(part.lo.y); y0 <= part.hi.y; y0 += n) {
      for (int z0 = first(part.lo.z); z0 <= part.hi.z; z0 += n) {
        const glm::ivec3 leaf_lo(x0, y0, z0);
        const glm::ivec3 from = glm::max(leaf_lo, part.lo), to = glm::min(leaf_lo + n - 1, part.hi);
        const int length = to.z - from.z + 1;
        const auto* leaf = accessor.probeConstLeaf(coord(leaf_lo));
        const Out tile = leaf ? Out{} : converted(accessor.getValue(coord(leaf_lo)));
        for (int x = from.x; x <= to.x; ++x) {
          for (int y = from.y; y <= to.y; ++y) {
            Out* const row = out + ((x - lo.x) * stride_x + (y - lo.y) * stride_y + (from.z - lo.z));
            if (!leaf) {
              std::fill_n(row, length, tile);
              continue;
            }
            const auto* const values = leaf->buffer().data() + (((x - x0) * n + (y - y0)) * n + (from.z - z0));
            if (length == n) {
              copy_leaf_row(values, row, converted);
            } else {
              std::transform(values, values + length, row, converted);
            }
          }
        }
      }
    }
  }
}

// Lambdas instead of functions, so that loops that call them are vectorised.
constexpr auto kDistance = [](float distance) { return distance; };
constexpr auto kLabel = [](std::int32_t value) { return label_in(value); };
constexpr auto kHardness = [](std::int32_t value) { return hardness_in(value); };
constexpr auto kColor = [](std::int32_t value) { return color_in(value); };
constexpr auto kHardnessKept = [](std::int32_t value) { return hardness_kept_in(value); };

/// Copies a whole leaf, with the strides of the destination.
template <class Value, class Out, class Convert>
void copy_leaf(const Value* from, Out* to, std::ptrdiff_t stride_x, std::ptrdiff_t stride_y, const Convert& converted) {
  constexpr int n = openvdb::FloatTree::LeafNodeType::DIM;
  for (int x = 0; x < n; ++x, to += stride_x) {
    for (int y = 0; y < n; ++y, from += n) copy_leaf_row(from, to + y * stride_y, converted);
  }
}
/// Copies the lowest byte of each value, eight at a time.
TYPODONT_DISPATCH("arch=x86-64-v4", "avx2", "default")
void copy_labels(const std::int32_t* from, Tissue* to, std::ptrdiff_t stride_x, std::ptrdiff_t stride_y) {
  constexpr int n = openvdb::FloatTree::LeafNodeType::DIM;
  for (int x = 0; x < n; ++x, to += stride_x) {
    for (int y = 0; y < n; ++y, from += n) {
      const I8 labels = *reinterpret_cast<const I8*>(from) & kLabelByte;
      *reinterpret_cast<B8*>(to + y * stride_y) = __builtin_convertvector(labels, B8);
    }
  }
}

/// Prefetches a leaf (may be null) into the second-level cache, which can load more lines at once.
template <class Leaf>
void prefetch_leaf(const Leaf* leaf) {
  if (!leaf) return;
  constexpr int line = 64 / sizeof(typename Leaf::ValueType), kSecondLevel = 2;
  const auto* const values = leaf->buffer().data();
  for (int i = 0; i < static_cast<int>(Leaf::SIZE); i += line) __builtin_prefetch(values + i, 0, kSecondLevel);
}

/// Calls load(source) a few leaves before copy(source); otherwise copying mostly waits for memory.
template <class Sources, class Load, class Copy>
void copy_in_turn(const Sources& sources, const Load& load, const Copy& copy) {
  constexpr std::size_t kAhead = 4;  // number of leaves that are prefetched ahead; a larger number is not faster
  for (std::size_t i = 0; i < sources.size() + kAhead; ++i) {
    if (i < sources.size()) load(sources[i]);
    if (i >= kAhead) copy(sources[i - kAhead]);
  }
}

/// Returns true if `part` and the destination `box` both begin and end at borders of leaves.
bool has_whole_leaves(const TissueVolume::Copied& box, const VoxelBox& part) {
  const glm::ivec3 all = box.lo | box.size | part.lo | (part.hi + 1);
  return ((all.x | all.y | all.z) & (openvdb::FloatTree::LeafNodeType::DIM - 1)) == 0;
}

}  // namespace

/// Finds leaves by their first voxels.
class TissueVolume::Impl::LeafFinder {
 public:
  explicit LeafFinder(const Impl& volume)
      : distances_(volume.distance->getConstAccessor()), labels_(volume.tissue->getConstAccessor()) {}
  LeafSource operator()(const glm::ivec3& lo) const {
    const openvdb::Coord origin = coord(lo);
    LeafSource source{lo, distances_.probeConstLeaf(origin), labels_.probeConstLeaf(origin), 0, 0};
    if (source.distances) {
      __builtin_prefetch(&source.distances->buffer());
    } else {
      source.distance = distances_.getValue(origin);
    }
    if (source.labels) {
      __builtin_prefetch(&source.labels->buffer());
    } else {
      source.label = labels_.getValue(origin);
    }
    return source;
  }

 private:
  openvdb::FloatGrid::ConstAccessor distances_;
  openvdb::Int32Grid::ConstAccessor labels_;
};

std::vector<TissueVolume::Impl::LeafSource> TissueVolume::Impl::leaves_in(const VoxelBox& part) const {
  constexpr int n = openvdb::FloatTree::LeafNodeType::DIM;
  const glm::ivec3 leaves = (part.hi - part.lo + 1) / n;
  std::vector<LeafSource> sources;
  sources.reserve(static_cast<std::size_t>(leaves.x) * leaves.y * leaves.z);
  const LeafFinder find(*this);
  for (int x = part.lo.x; x <= part.hi.x; x += n) {
    for (int y = part.lo.y; y <= part.hi.y; y += n) {
      for (int z = part.lo.z; z <= part.hi.z; z += n) sources.push_back(find({x, y, z}));
    }
  }
  return sources;
}

/// Copies whole leaves (has_whole_leaves()). The caller has already found the leaves, so memory accesses overlap.
void TissueVolume::Impl::copy_whole_leaves(const Copied& box, const std::vector<LeafSource>& sources) const {
  const std::ptrdiff_t stride_y = box.size.z, stride_x = stride_y * box.size.y;
  const auto place = [&](const LeafSource& source) {
    const glm::ivec3 at = source.lo - box.lo;
    return at.x * stride_x + at.y * stride_y + at.z;
  };
  const auto load = [&](const LeafSource& source) {
    prefetch_leaf(source.distances);
    prefetch_leaf(source.labels);
    prefetch_rows(box.distance + place(source), stride_x, stride_y);
    prefetch_rows(box.tissue + place(source), stride_x, stride_y);
  };
  copy_in_turn(sources, load, [&](const LeafSource& source) {
    const std::ptrdiff_t to = place(source);
    if (source.distances) {
      copy_distances(source.distances->buffer().data(), box.distance + to, stride_x, stride_y);
    } else {
      fill_distances(source.distance, box.distance + to, stride_x, stride_y);
    }
    if (source.labels) {
      copy_labels(source.labels->buffer().data(), box.tissue + to, stride_x, stride_y);
    } else {
      fill_leaf(label_in(source.label), box.tissue + to, stride_x, stride_y);
    }
    if (!box.hardness) return;
    if (source.labels) {
      copy_leaf(source.labels->buffer().data(), box.hardness + to, stride_x, stride_y, kHardnessKept);
    } else {
      fill_leaf(hardness_kept_in(source.label), box.hardness + to, stride_x, stride_y);
    }
  });
}

void TissueVolume::copy_step(const VoxelBox& part, PatchStep& step) const {
  constexpr int n = openvdb::FloatTree::LeafNodeType::DIM, stride_y = n, stride_x = n * n;
  static_assert(n == kLeafSide && n == PatchStep::kSide);
  const auto load = [](const Impl::LeafSource& source) {
    prefetch_leaf(source.distances);
    prefetch_leaf(source.labels);
  };
  copy_in_turn(impl_->leaves_in(part), load, [&](const Impl::LeafSource& source) {
    step.add({source.lo, !source.distances, !source.labels, source.distance, label_in(source.label),
              hardness_kept_in(source.label)});
    const PatchStep::Samples to = step.samples(step.size() - 1);
    if (source.distances) copy_distances(source.distances->buffer().data(), to.distance, stride_x, stride_y);
    if (!source.labels) return;
    copy_labels(source.labels->buffer().data(), to.label, stride_x, stride_y);
    if (to.hardness) copy_leaf(source.labels->buffer().data(), to.hardness, stride_x, stride_y, kHardnessKept);
  });
}

void TissueVolume::copy(const glm::ivec3& lo, const glm::ivec3& size, float* distance, Tissue* tissue,
                        std::uint8_t* hardness) const {
  copy_for_patch(lo, size, distance, tissue);
  const std::size_t count = static_cast<std::size_t>(size.x) * size.y * size.z;
  if (tissue && !impl_->filled.empty()) std::transform(tissue, tissue + count, tissue, shown);
  if (hardness) copy_box(*impl_->tissue, lo, size, {lo, lo + size - 1}, hardness, kHardness);
}

void TissueVolume::copy_colors(const glm::ivec3& lo, const glm::ivec3& size, VoxelColor* color) const {
  copy_box(*impl_->tissue, lo, size, {lo, lo + size - 1}, color, kColor);
}

glm::vec4 TissueVolume::paint_at(const dvec3& p_V, const PaintOf& paint_of) const {
  const glm::ivec3 low(glm::floor(p_V));
  const dvec3 part = p_V - dvec3(low);
  openvdb::tree::ValueAccessor<const openvdb::Int32Tree, /*IsSafe=*/false> values(impl_->tissue->tree());
  dvec3 sum(0);
  double painted = 0, all = 0;
  for (int corner = 0; corner < 8; ++corner) {
    const glm::ivec3 up(corner & 1, corner >> 1 & 1, corner >> 2);
    const dvec3 w = glm::mix(1.0 - part, part, dvec3(up));
    const std::int32_t value = values.getValue(coord(low + up));
    const double weight = w.x * w.y * w.z;
    const Tissue shown = shown_in(value);
    if (shown == Tissue::kAir) continue;
    all += weight;
    const glm::dvec4 paint = paint_of(shown, hardness_fraction(hardness_in(value)), color_in(value));
    painted += weight * paint.w;
    sum += weight * paint.w * dvec3(paint);
  }
  if (painted == 0) return glm::vec4(0);
  return {glm::vec3(sum / painted), static_cast<float>(painted / all)};
}

glm::vec4 TissueVolume::color_at(const dvec3& p_V, std::uint32_t tissues) const {
  if (!impl_->colored) return glm::vec4(0);
  return paint_at(p_V, [tissues](Tissue tissue, double /*hardness*/, VoxelColor color) {
    const bool counts = color != kTissueColor && (tissues >> static_cast<int>(tissue) & 1);
    return counts ? glm::dvec4(srgb_of(color), 1) : glm::dvec4(0);
  });
}

void TissueVolume::filled_box(const glm::ivec3& lo, const glm::ivec3& hi, glm::ivec3& a_lo, glm::ivec3& a_hi) const {
  a_lo = glm::ivec3(INT_MAX), a_hi = glm::ivec3(INT_MIN);
  constexpr int n = openvdb::Int32Tree::LeafNodeType::DIM;
  for (const glm::ivec3& key : impl_->filled) {
    const VoxelBox part = common({lo, hi}, {key * n, key * n + n - 1});
    if (!part.empty()) a_lo = glm::min(a_lo, part.lo), a_hi = glm::max(a_hi, part.hi);
  }
}

void TissueVolume::copy_for_patch(const glm::ivec3& lo, const glm::ivec3& size, float* distance, Tissue* tissue,
                                  std::uint8_t* hardness) const {
  copy_part({lo, size, distance, tissue, hardness}, {lo, lo + size - 1});
}

void TissueVolume::copy_part(const Copied& box, const VoxelBox& part) const {
  if (part.empty()) return;
  static_assert(sizeof(Tissue) == 1);  // one byte in tissue patches, int32 in the grid
  if (box.distance && box.tissue && has_whole_leaves(box, part))
    return impl_->copy_whole_leaves(box, impl_->leaves_in(part));
  if (box.distance) copy_box(*impl_->distance, box.lo, box.size, part, box.distance, kDistance);
  if (box.tissue) copy_box(*impl_->tissue, box.lo, box.size, part, box.tissue, kLabel);
  if (box.hardness) copy_box(*impl_->tissue, box.lo, box.size, part, box.hardness, kHardnessKept);
}

void TissueVolume::copy_leaves(const Copied& box, std::span<const glm::ivec3> leaves) const {
  std::vector<Impl::LeafSource> sources;
  sources.reserve(leaves.size());
  const Impl::LeafFinder find(*impl_);
  for (const glm::ivec3& lo : leaves) sources.push_back(find(lo));
  impl_->copy_whole_leaves(box, sources);
}

void TissueVolume::copy_every(int n, const glm::ivec3& lo, const glm::ivec3& size, float* distance, Tissue* tissue,
                              std::uint8_t* hardness) const {
  copy_part_of_every(n, {lo, size, distance, tissue, hardness}, {lo, lo + size - 1});
}

void TissueVolume::copy_part_of_every(int n, const Copied& box, const VoxelBox& part) const {
  impl_->copy_every(n, box, part.lo, part.hi);
}

VoxelBox TissueVolume::every_around(int n, const VoxelBox& written) {
  // Extends the box to whole bricks, because copy_every() treats deep samples differently after a brick's first cut.
  constexpr int cells = FieldBrick::kCells;
  const BrickBox bricks = bricks_around(written.lo, written.hi);
  const auto down = [n](const glm::ivec3& p) {
    return glm::ivec3(floor_div(p.x, n), floor_div(p.y, n), floor_div(p.z, n));
  };
  return {down(bricks.lo * cells), down((bricks.hi + 1) * cells) + 1};
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
        const std::int32_t value = d < 3.0f * static_cast<float>(n) ? labels.getValue(coord(p)) : 0;
        box.tissue[i] = shown_in(value);
        if (box.hardness) box.hardness[i] = hardness_in(value);
      }
    }
  }
}

TissueVolume TissueVolume::clone() const {
  auto copy = std::make_unique<Impl>();
  const Impl& v = *impl_;
  copy->distance = v.distance->deepCopy();
  copy->tissue = v.tissue->deepCopy();
  copy->frame = v.frame, copy->band = v.band, copy->exact_outside = v.exact_outside;
  copy->place = v.place;
  copy->carved = v.carved;
  copy->filled = v.filled;
  copy->graded = v.graded, copy->colored = v.colored;
  copy->mesh = v.mesh;
  copy->natural = v.natural;
  return TissueVolume(std::move(copy));
}

namespace {

constexpr int kLeafEdge = openvdb::FloatTree::LeafNodeType::DIM;

/// For each row of eight samples: bit mask of the samples with distance low <= d < high; the first sample is bit 0.
TYPODONT_DISPATCH("avx2", "default")
void samples_within(const float* leaf, float low, float high, std::uint8_t* rows) {
  for (int row = 0; row < kLeafEdge * kLeafEdge; ++row, leaf += kLeafEdge) {
    const F8 d = *reinterpret_cast<const F8*>(leaf);
    rows[row] = static_cast<std::uint8_t>(bits_of((d >= low) & (d < high)));
  }
}

/// Like samples_within() for d < 0, in half the time.
TYPODONT_DISPATCH("avx2", "default")
void samples_in_tissue(const float* leaf, std::uint8_t* rows) {
  for (int row = 0; row < kLeafEdge * kLeafEdge; ++row, leaf += kLeafEdge) {
    rows[row] = static_cast<std::uint8_t>(bits_of(*reinterpret_cast<const F8*>(leaf) < 0.0f));
  }
}

}  // namespace

void TissueVolume::solid_block(const glm::ivec3& key, SolidBits& bits) const {
  const openvdb::Coord origin = coord(key * kLeafEdge);
  const auto& tree = impl_->distance->tree();
  const auto* leaf = tree.probeConstLeaf(origin);
  if (!leaf) {
    bits.fill(tree.getValue(origin) < 0 ? ~std::uint64_t{0} : 0);
    return;
  }
  bits = solid_bits(leaf->buffer().data());
}

namespace {

/// Computes TissueVolume::tissues_in_block().
TYPODONT_DISPATCH("avx2", "default")
std::uint32_t tissues_of(const std::int32_t* values) {
  std::uint32_t tissues = 0;
  for (int i = 0; i < kLeafEdge * kLeafEdge * kLeafEdge; ++i) tissues |= 1u << (values[i] & kShown);
  return tissues;
}

}  // namespace

std::uint32_t TissueVolume::tissues_in_block(const glm::ivec3& key) const {
  const openvdb::Coord origin = coord(key * kLeafEdge);
  const auto& tree = impl_->tissue->tree();
  if (const auto* leaf = tree.probeConstLeaf(origin)) return tissues_of(leaf->buffer().data());
  return 1u << static_cast<int>(shown_in(tree.getValue(origin)));
}

VoxelBox TissueVolume::box_of(Tissue tissue) const {
  const auto& tree = impl_->tissue->tree();
  openvdb::CoordBBox box;
  for (auto leaf = tree.cbeginLeaf(); leaf; ++leaf)
    if (tissues_of(leaf->buffer().data()) >> static_cast<int>(tissue) & 1) box.expand(leaf->getNodeBoundingBox());
  auto tile = tree.cbeginValueAll();
  tile.setMaxDepth(decltype(tile)::LEAF_DEPTH - 1);
  for (; tile; ++tile)
    if (shown_in(*tile) == tissue) box.expand(tile.getBoundingBox());
  return box.empty() ? VoxelBox{} : VoxelBox{vec(box.min()), vec(box.max())};
}

SolidBits solid_bits(const float* samples) {
  std::uint8_t rows[kLeafEdge * kLeafEdge];
  samples_in_tissue(samples, rows);
  SolidBits bits{};
  for (std::size_t x = 0; x < bits.size(); ++x) {
    for (std::size_t y = 0; y < kLeafEdge; ++y) bits[x] |= static_cast<std::uint64_t>(rows[kLeafEdge * x + y]) << 8 * y;
  }
  return bits;
}

std::vector<glm::ivec3> TissueVolume::surface_bricks() const {
  // The surface passes between neighbouring samples of opposite sign; at least one has |distance| <= 2.
  const float nearest = -2, farthest = std::nextafter(2.0f, 3.0f);
  KeySet keys;
  for (auto leaf = impl_->distance->tree().cbeginLeaf(); leaf; ++leaf) {
    std::uint8_t rows[kLeafEdge * kLeafEdge];
    samples_within(leaf->buffer().data(), nearest, farthest, rows);
    // Box lo..hi of the samples with |distance| <= 2, relative to the leaf's origin. Sample (x, y, z) is bit 8y + z of
    // word x, in `rows` and in the mask.
    glm::ivec3 lo(kLeafEdge, 0, 0), hi(-1, 0, 0);
    std::uint64_t near = 0;
    for (int x = 0; x < kLeafEdge; ++x) {
      std::uint64_t bits;
      std::memcpy(&bits, rows + kLeafEdge * x, sizeof bits);
      bits &= leaf->getValueMask().getWord<std::uint64_t>(static_cast<openvdb::Index>(x));
      near |= bits;
      if (bits != 0) lo.x = std::min(lo.x, x), hi.x = x;
    }
    if (near == 0) continue;
    lo.y = std::countr_zero(near) / kLeafEdge, hi.y = (std::bit_width(near) - 1) / kLeafEdge;
    near |= near >> 32, near |= near >> 16, near |= near >> 8;
    near &= 0xff;
    lo.z = std::countr_zero(near), hi.z = std::bit_width(near) - 1;
    const glm::ivec3 origin = vec(leaf->origin());
    insert_bricks(origin + lo, origin + hi, keys);
  }
  return sorted(keys);
}

std::vector<glm::ivec3> TissueVolume::take_changed_bricks() {
  const auto list = sorted(impl_->changed);
  impl_->changed.clear();
  impl_->marked_lo = glm::ivec3(0), impl_->marked_hi = glm::ivec3(-1);
  return list;
}

namespace {

/// Returns true if at least one cell corner of the brick is inside tissue, and at least one outside.
TYPODONT_DISPATCH("avx2", "default")
bool has_surface(const FieldBrick& brick) {
  unsigned any = 0, all = ~0u;
  for (int x = 1; x < FieldBrick::kSamples - 1; ++x) {
    for (int y = 1; y < FieldBrick::kSamples - 1; ++y) {
      const float* row = &brick.distance[FieldBrick::at(x, y, 1)];
      static_assert(FieldBrick::kCells == 16);
      const F8 low = *reinterpret_cast<const F8*>(row), high = *reinterpret_cast<const F8*>(row + 8);
      const unsigned solid =
          bits_of(low < 0) | bits_of(high < 0) << 8 | static_cast<unsigned>(row[FieldBrick::kCells] < 0) << 16;
      any |= solid;
      all &= solid;
    }
    if (any != 0 && all != 0x1ffff) return true;
  }
  return false;
}

/// A brick reads four leaves per axis: one leaf's last sample, two whole leaves, and the first two samples of a leaf.
template <class Grid, class Out, class Convert>
void copy_brick(const Grid& grid, const glm::ivec3& key, Out* out, const Convert& converted) {
  using Value = typename Grid::ValueType;
  constexpr int n = kLeafEdge, side = FieldBrick::kSamples;
  static_assert(FieldBrick::kCells == 2 * n && side == 2 * n + 3);
  static constexpr int kFrom[4] = {n - 1, 0, 0, 0}, kCount[4] = {1, n, n, 2};
  auto accessor = grid.getConstAccessor();
  const glm::ivec3 first = key * FieldBrick::kCells - n;
  Value tile[4][n];  // for each tile that replaces a leaf: n copies of the tile's value
  for (int i = 0; i < 4; ++i) {
    for (int j = 0; j < 4; ++j) {
      const Value* leaf[4];
      std::ptrdiff_t stride_x[4], stride_y[4];
      for (int k = 0; k < 4; ++k) {
        const openvdb::Coord origin(first.x + n * i, first.y + n * j, first.z + n * k);
        if (const auto* found = accessor.probeConstLeaf(origin)) {
          leaf[k] = found->buffer().data() + (kFrom[i] * n + kFrom[j]) * n;
          stride_x[k] = n * n, stride_y[k] = n;
        } else {
          std::fill_n(tile[k], n, accessor.getValue(origin));
          leaf[k] = tile[k];
          stride_x[k] = stride_y[k] = 0;
        }
      }
      const int to_x = i == 0 ? 0 : 1 + n * (i - 1), to_y = j == 0 ? 0 : 1 + n * (j - 1);
      for (int x = 0; x < kCount[i]; ++x) {
        const Value* row[4];
        for (int k = 0; k < 4; ++k) row[k] = leaf[k] + x * stride_x[k];
        Out* to = out + ((to_x + x) * side + to_y) * side;
        for (int y = 0; y < kCount[j]; ++y, to += side) {
          to[0] = converted(row[0][n - 1]);
          copy_leaf_row(row[1], to + 1, converted);
          copy_leaf_row(row[2], to + 1 + n, converted);
          to[1 + 2 * n] = converted(row[3][0]);
          to[2 + 2 * n] = converted(row[3][1]);
          for (int k = 0; k < 4; ++k) row[k] += stride_y[k];
        }
      }
    }
  }
}

}  // namespace

void TissueVolume::read_brick(const glm::ivec3& key, FieldBrick& brick) const {
  brick.key = key;
  copy_brick(*impl_->distance, key, brick.distance.data(), kDistance);
  if (has_surface(brick)) {
    copy_brick(*impl_->tissue, key, brick.tissue.data(), [](std::int32_t value) { return shown_in(value); });
    brick.colored = impl_->colored;
    if (brick.colored) copy_brick(*impl_->tissue, key, brick.color.data(), kColor);
  } else {
    brick.tissue.fill(Tissue::kAir);
    brick.colored = false;
  }
}

namespace {

/// For each tissue, sums (volume inside the surface × `weight`), m³. `weight`: function of the label grid's value.
template <class Weight>
PerTissue sum_volumes(const openvdb::FloatGrid& distance, const openvdb::Int32Grid& labels, double voxel,
                      const Weight& weight) {
  PerTissue volumes{};
  auto tissue = labels.getConstAccessor();
  const double voxel3 = voxel * voxel * voxel;
  for (auto it = distance.cbeginValueAll(); it; ++it) {
    const double fraction = fraction_inside(*it);
    if (fraction == 0) continue;
    const auto add = [&](const openvdb::Coord& at) {
      const std::int32_t value = tissue.getValue(at);
      volumes[static_cast<std::size_t>(shown_in(value))] += fraction * voxel3 * weight(value);
    };
    if (it.isVoxelValue()) {
      add(it.getCoord());
      continue;
    }
    openvdb::CoordBBox box;
    it.getBoundingBox(box);
    for (auto c = box.begin(); c; ++c) add(*c);
  }
  volumes[0] = 0;
  return volumes;
}

}  // namespace

PerTissue TissueVolume::volumes() const {
  return sum_volumes(*impl_->distance, *impl_->tissue, impl_->frame.voxel, [](std::int32_t) { return 1.0; });
}

PerTissue TissueVolume::hardness_volumes() const {
  return sum_volumes(*impl_->distance, *impl_->tissue, impl_->frame.voxel,
                     [](std::int32_t value) { return hardness_fraction(hardness_in(value)); });
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
