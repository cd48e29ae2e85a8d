// The grids store lengths in voxels, because sampling and cutting compute in voxels.
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
template <class Grid>
void count_leaves(const Grid& grid, std::unordered_map<std::uintptr_t, std::size_t>& bytes) {
  grid.for_each_block([&](const glm::ivec3&, const typename Grid::Block& block) {
    if (block.leaf)
      bytes[reinterpret_cast<std::uintptr_t>(block.leaf.get()) / kHugePage] += sizeof(typename Grid::Leaf);
  });
}

/// Requests huge memory pages. With pages of 4 kB, address translation takes up to a fifth of the time for copying.
/// Results do not depend on the page size.
void store_in_huge_pages(const DistanceGrid& distances, const LabelGrid& labels) {
  std::unordered_map<std::uintptr_t, std::size_t> bytes;
  count_leaves(distances, bytes);
  count_leaves(labels, bytes);
  for (const auto& [page, of_leaves] : bytes) {
    if (of_leaves >= kHugePage / 2) madvise(reinterpret_cast<void*>(page * kHugePage), kHugePage, MADV_COLLAPSE);
  }
}

}  // namespace

TissueVolume::TissueVolume(const DenseTissue& dense)
    : impl_(std::make_unique<Impl>(DistanceGrid(static_cast<float>(dense.band / dense.frame.voxel)), LabelGrid(0))) {
  Impl& v = *impl_;
  v.frame = dense.frame;
  v.band = dense.band;
  v.exact_outside = dense.exact_outside;
  v.place = dense.place;
  v.graded = std::ranges::any_of(dense.hardness, [](std::uint8_t hardness) { return hardness != kOwnHardness; });
  v.colored = std::ranges::any_of(dense.color, [](VoxelColor color) { return color != kTissueColor; });

  // Stores leaf by leaf, which saves memory where no distances are stored.
  constexpr int n = DistanceGrid::kSide;
  const auto to_voxels = static_cast<float>(1 / dense.frame.voxel), band = static_cast<float>(dense.band);
  const float band_voxels = v.distance.background();
  for_each_voxel((dense.size + (n - 1)) / n, [&](const glm::ivec3& key) {
    const glm::ivec3 first = key * n, end = glm::min(first + n, dense.size);
    if (const auto value = uniform_inside(dense, first, end, n)) {
      v.distance.block(key) = DistanceGrid::Block(-band_voxels, false);
      v.tissue.block(key) = LabelGrid::Block(*value, label_in(*value) != Tissue::kAir);
      return;
    }
    // leaves of both grids, created when their first voxel is stored
    DistanceGrid::Leaf* distances = nullptr;
    LabelGrid::Leaf* labels = nullptr;
    for_each_voxel_between(first, end - 1, [&](int x, int y, int z) {
      const std::size_t from = dense.at(x, y, z);
      const int to = DistanceGrid::Leaf::index({x, y, z});
      if (const float d = dense.distance[from]; d < band) {
        if (!distances) distances = &v.distance.block(key).touch();
        distances->set(to, d > -band ? d * to_voxels : -band_voxels, d > -band);
      }
      if (dense.tissue[from] != Tissue::kAir) {
        if (!labels) labels = &v.tissue.block(key).touch();
        labels->set(to, value_at(dense, from));
      }
    });
  });
  v.distance.prune();
  v.tissue.prune();
  store_in_huge_pages(v.distance, v.tissue);
}

TissueVolume TissueVolume::load(const std::filesystem::path& file) {
  StoredVolume stored = read_volume(file);
  auto impl = std::make_unique<Impl>(std::move(stored.distance), std::move(stored.tissue));
  impl->frame = stored.frame;
  impl->band = stored.band;
  impl->exact_outside = stored.exact_outside;
  impl->place = stored.place;
  if (stored.before) impl->put_before(*stored.before);
  impl->graded = stored.hardness && impl->put(Impl::kHardnessPart, *stored.hardness);
  impl->colored = stored.color && impl->put(Impl::kColorPart, *stored.color);
  store_in_huge_pages(impl->distance, impl->tissue);
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

std::optional<LabelGrid> TissueVolume::Impl::take(const Part& part, LabelGrid& labels) {
  LabelGrid taken(part.usual);
  labels.for_each_block([&](const glm::ivec3& key, LabelGrid::Block& block) {
    const auto split = [&](std::int32_t& value, const auto& store) {
      const std::int32_t own = part.get(value);
      if (own == part.usual) return;
      store(own);
      value = part.set(value, part.usual);
    };
    if (!block.leaf) {
      if (block.tile_on) split(block.tile, [&](std::int32_t own) { taken.block(key) = LabelGrid::Block(own, true); });
      return;
    }
    for (int i = 0; i < LabelGrid::kSize; ++i)
      if (block.leaf->is_on(i))
        split(block.leaf->values[static_cast<std::size_t>(i)], [&](std::int32_t own) { taken.block(key).set(i, own); });
  });
  if (taken.empty()) return std::nullopt;
  return taken;
}

bool TissueVolume::Impl::put(const Part& part, const LabelGrid& values) {
  LabelGrid::Reader of(values);
  bool unusual = false;
  const auto with = [&](std::int32_t value, std::int32_t own) {
    unusual |= own != part.usual;
    return part.set(value, own);
  };
  tissue.for_each_block([&](const glm::ivec3& key, LabelGrid::Block& block) {
    const LabelGrid::Block& from = of.block(key);
    if (!block.leaf && !block.tile_on) return;
    if (!block.leaf && !from.leaf) {
      block.tile = with(block.tile, from.tile);
      return;
    }
    for (int i = 0; i < LabelGrid::kSize; ++i)
      if (block.is_on(i)) block.touch().set(i, with(block.value(i), from.value(i)));
  });
  tissue.prune();
  return unusual;
}

std::optional<LabelGrid> TissueVolume::Impl::take_before(LabelGrid& labels) const {
  LabelGrid before(0);
  for (const glm::ivec3& key : filled) {
    LabelGrid::Leaf* const leaf = labels.block(key).leaf.get();
    for (int i = 0; leaf && i < LabelGrid::kSize; ++i) {
      const Tissue label = label_in(leaf->values[static_cast<std::size_t>(i)]);
      if (!leaf->is_on(i) || !is_filled(label)) continue;
      before.block(key).set(i, static_cast<int>(emptied(label)) + 1);
      leaf->set(i, static_cast<int>(shown(label)));
    }
  }
  if (before.empty()) return std::nullopt;
  return before;
}

void TissueVolume::Impl::put_before(const LabelGrid& before) {
  before.for_each_block([&](const glm::ivec3& key, const LabelGrid::Block& from) {
    LabelGrid::Block& to = tissue.block(key);
    for (int i = 0; i < LabelGrid::kSize; ++i) {
      if (!from.is_on(i)) continue;
      to.set(i, static_cast<int>(haptics::filled(static_cast<Tissue>(from.value(i) - 1), shown_in(to.value(i)))));
      filled.insert(key);
    }
  });
}

void TissueVolume::save(const std::filesystem::path& file) const {
  const Impl& v = *impl_;
  StoredVolume stored{v.distance, v.tissue, {}, {}, {}, v.frame, v.band, v.exact_outside && v.carved.empty(), v.place};
  if (v.graded) stored.hardness = Impl::take(Impl::kHardnessPart, stored.tissue);
  if (v.colored) stored.color = Impl::take(Impl::kColorPart, stored.tissue);
  stored.before = v.take_before(stored.tissue);
  write_volume(file, std::move(stored));
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
  const VoxelBox box = impl_->distance.box_on();
  lo = box.lo, hi = box.hi;
  if (box.empty()) lo = {0, 0, 0}, hi = {-1, -1, -1};
}

namespace {

/// Converts a leaf's row in a local array, vectorised.
template <class Value, class Out, class Convert>
void copy_leaf_row(const Value* from, Out* to, const Convert& converted) {
  constexpr int n = DistanceGrid::kSide;
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
  constexpr int n = Grid::kSide;
  const std::ptrdiff_t stride_y = size.z, stride_x = stride_y * size.y;
  typename Grid::Reader reader(grid);
  const auto first = [](int v) { return floor_div(v, n) * n; };
  for (int x0 = first(part.lo.x); x0 <= part.hi.x; x0 += n) {
    for (int y0 = first(part.lo.y); y0 <= part.hi.y; y0 += n) {
      for (int z0 = first(part.lo.z); z0 <= part.hi.z; z0 += n) {
        const glm::ivec3 leaf_lo(x0, y0, z0);
        const glm::ivec3 from = glm::max(leaf_lo, part.lo), to = glm::min(leaf_lo + n - 1, part.hi);
        const int length = to.z - from.z + 1;
        const auto& block = reader.block(leaf_lo / n);
        const auto* const leaf = block.leaf.get();
        const Out tile = leaf ? Out{} : converted(block.tile);
        for (int x = from.x; x <= to.x; ++x) {
          for (int y = from.y; y <= to.y; ++y) {
            Out* const row = out + ((x - lo.x) * stride_x + (y - lo.y) * stride_y + (from.z - lo.z));
            if (!leaf) {
              std::fill_n(row, length, tile);
              continue;
            }
            const auto* const values = leaf->data() + (((x - x0) * n + (y - y0)) * n + (from.z - z0));
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
  constexpr int n = DistanceGrid::kSide;
  for (int x = 0; x < n; ++x, to += stride_x) {
    for (int y = 0; y < n; ++y, from += n) copy_leaf_row(from, to + y * stride_y, converted);
  }
}
/// Copies the lowest byte of each value, eight at a time.
TYPODONT_DISPATCH("arch=x86-64-v4", "avx2", "default")
void copy_labels(const std::int32_t* from, Tissue* to, std::ptrdiff_t stride_x, std::ptrdiff_t stride_y) {
  constexpr int n = DistanceGrid::kSide;
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
  constexpr int kLine = 64, kSecondLevel = 2;
  const auto* const bytes = reinterpret_cast<const char*>(leaf->data());
  for (std::size_t i = 0; i < sizeof leaf->values; i += kLine) __builtin_prefetch(bytes + i, 0, kSecondLevel);
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
  return ((all.x | all.y | all.z) & (DistanceGrid::kSide - 1)) == 0;
}

}  // namespace

/// Finds leaves by their first voxels.
class TissueVolume::Impl::LeafFinder {
 public:
  explicit LeafFinder(const Impl& volume) : distances_(volume.distance), labels_(volume.tissue) {}
  LeafSource operator()(const glm::ivec3& lo) {
    const glm::ivec3 key = leaf_key(lo);
    return {lo, &distances_.block(key), &labels_.block(key)};
  }

 private:
  DistanceGrid::Reader distances_;
  LabelGrid::Reader labels_;
};

std::vector<TissueVolume::Impl::LeafSource> TissueVolume::Impl::leaves_in(const VoxelBox& part) const {
  constexpr int n = DistanceGrid::kSide;
  const glm::ivec3 leaves = (part.hi - part.lo + 1) / n;
  std::vector<LeafSource> sources;
  sources.reserve(voxel_count(leaves));
  LeafFinder find(*this);
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
  const auto offset = [&](const LeafSource& source) {
    const glm::ivec3 at = source.lo - box.lo;
    return at.x * stride_x + at.y * stride_y + at.z;
  };
  const auto load = [&](const LeafSource& source) {
    prefetch_leaf(source.distances->leaf.get());
    prefetch_leaf(source.labels->leaf.get());
    prefetch_rows(box.distance + offset(source), stride_x, stride_y);
    prefetch_rows(box.tissue + offset(source), stride_x, stride_y);
  };
  copy_in_turn(sources, load, [&](const LeafSource& source) {
    const std::ptrdiff_t to = offset(source);
    const DistanceGrid::Block& distances = *source.distances;
    const LabelGrid::Block& labels = *source.labels;
    if (distances.leaf) {
      copy_distances(distances.leaf->data(), box.distance + to, stride_x, stride_y);
    } else {
      fill_distances(distances.tile, box.distance + to, stride_x, stride_y);
    }
    if (labels.leaf) {
      copy_labels(labels.leaf->data(), box.tissue + to, stride_x, stride_y);
    } else {
      fill_leaf(label_in(labels.tile), box.tissue + to, stride_x, stride_y);
    }
    if (!box.hardness) return;
    if (labels.leaf) {
      copy_leaf(labels.leaf->data(), box.hardness + to, stride_x, stride_y, kHardnessKept);
    } else {
      fill_leaf(hardness_kept_in(labels.tile), box.hardness + to, stride_x, stride_y);
    }
  });
}

void TissueVolume::copy_step(const VoxelBox& part, PatchStep& step) const {
  constexpr int n = DistanceGrid::kSide, stride_y = n, stride_x = n * n;
  static_assert(n == kLeafSide && n == PatchStep::kSide);
  const auto load = [](const Impl::LeafSource& source) {
    prefetch_leaf(source.distances->leaf.get());
    prefetch_leaf(source.labels->leaf.get());
  };
  copy_in_turn(impl_->leaves_in(part), load, [&](const Impl::LeafSource& source) {
    const DistanceGrid::Block& distances = *source.distances;
    const LabelGrid::Block& labels = *source.labels;
    step.add({source.lo, !distances.leaf, !labels.leaf, distances.tile, label_in(labels.tile),
              hardness_kept_in(labels.tile)});
    const PatchStep::Samples to = step.samples(step.size() - 1);
    if (distances.leaf) copy_distances(distances.leaf->data(), to.distance, stride_x, stride_y);
    if (!labels.leaf) return;
    copy_labels(labels.leaf->data(), to.label, stride_x, stride_y);
    if (to.hardness) copy_leaf(labels.leaf->data(), to.hardness, stride_x, stride_y, kHardnessKept);
  });
}

void TissueVolume::copy(const glm::ivec3& lo, const glm::ivec3& size, float* distance, Tissue* tissue,
                        std::uint8_t* hardness) const {
  copy_for_patch(lo, size, distance, tissue);
  const std::size_t count = voxel_count(size);
  if (tissue && !impl_->filled.empty()) std::transform(tissue, tissue + count, tissue, shown);
  if (hardness) copy_box(impl_->tissue, lo, size, {lo, lo + size - 1}, hardness, kHardness);
}

void TissueVolume::copy_colors(const glm::ivec3& lo, const glm::ivec3& size, VoxelColor* color) const {
  copy_box(impl_->tissue, lo, size, {lo, lo + size - 1}, color, kColor);
}

glm::vec4 TissueVolume::paint_at(const dvec3& p_V, const PaintOf& paint_of) const {
  const glm::ivec3 low(glm::floor(p_V));
  const dvec3 part = p_V - dvec3(low);
  LabelGrid::Reader values(impl_->tissue);
  dvec3 sum(0);
  double painted = 0, all = 0;
  for (int corner = 0; corner < 8; ++corner) {
    const glm::ivec3 up(corner & 1, corner >> 1 & 1, corner >> 2);
    const dvec3 w = glm::mix(1.0 - part, part, dvec3(up));
    const std::int32_t value = values.value(low + up);
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
  constexpr int n = LabelGrid::kSide;
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
  if (box.distance) copy_box(impl_->distance, box.lo, box.size, part, box.distance, kDistance);
  if (box.tissue) copy_box(impl_->tissue, box.lo, box.size, part, box.tissue, kLabel);
  if (box.hardness) copy_box(impl_->tissue, box.lo, box.size, part, box.hardness, kHardnessKept);
}

void TissueVolume::copy_leaves(const Copied& box, std::span<const glm::ivec3> leaves) const {
  std::vector<Impl::LeafSource> sources;
  sources.reserve(leaves.size());
  Impl::LeafFinder find(*impl_);
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
  DistanceGrid::Reader distances(v.distance);
  LabelGrid::Reader labels(v.tissue);
  const float scale = 1.0f / static_cast<float>(n);
  constexpr int m = FieldBrick::kCells;
  glm::ivec3 brick(INT_MAX);
  bool was_cut = false;
  for (int x = from.x; x <= to.x; ++x) {
    for (int y = from.y; y <= to.y; ++y) {
      std::size_t i = voxel_index(glm::ivec3(x, y, from.z) - box.lo, box.size);
      for (int z = from.z; z <= to.z; ++z, ++i) {
        const glm::ivec3 p = glm::ivec3(x, y, z) * n;
        float d = distances.value(p);
        if (d < -Sweep::kMargin && !v.carved.empty()) {
          const glm::ivec3 in(floor_div(p.x, m), floor_div(p.y, m), floor_div(p.z, m));
          if (in != brick) brick = in, was_cut = v.carved.contains(in);
          if (was_cut) d = -Sweep::kMargin;
        }
        box.distance[i] = d * scale;
        const std::int32_t value = d < 3.0f * static_cast<float>(n) ? labels.value(p) : 0;
        box.tissue[i] = shown_in(value);
        if (box.hardness) box.hardness[i] = hardness_in(value);
      }
    }
  }
}

TissueVolume TissueVolume::clone() const {
  const Impl& v = *impl_;
  auto copy = std::make_unique<Impl>(DistanceGrid(v.distance), LabelGrid(v.tissue));
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

constexpr int kLeafEdge = DistanceGrid::kSide;

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
  const DistanceGrid::Block& block = std::as_const(impl_->distance).block(key);
  if (block.leaf) {
    bits = solid_bits(block.leaf->data());
  } else {
    bits.fill(block.tile < 0 ? ~std::uint64_t{0} : 0);
  }
}

namespace {

/// Computes TissueVolume::tissues_in_block().
TYPODONT_DISPATCH("avx2", "default")
std::uint32_t tissues_of(const std::int32_t* values) {
  std::uint32_t tissues = 0;
  for (int i = 0; i < kLeafEdge * kLeafEdge * kLeafEdge; ++i) tissues |= 1u << (values[i] & kShown);
  return tissues;
}

/// The shown tissues of a block: bit t is set if a voxel shows tissue t.
std::uint32_t tissues_of(const LabelGrid::Block& block) {
  return block.leaf ? tissues_of(block.leaf->data()) : 1u << static_cast<int>(shown_in(block.tile));
}

}  // namespace

std::uint32_t TissueVolume::tissues_in_block(const glm::ivec3& key) const {
  return tissues_of(std::as_const(impl_->tissue).block(key));
}

VoxelBox TissueVolume::box_of(Tissue tissue) const {
  VoxelBox box;
  impl_->tissue.for_each_block([&](const glm::ivec3& key, const LabelGrid::Block& block) {
    if (tissues_of(block) >> static_cast<int>(tissue) & 1)
      extend(box, {key * kLeafEdge, key * kLeafEdge + kLeafEdge - 1});
  });
  return box;
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
  impl_->distance.for_each_block([&](const glm::ivec3& key, const DistanceGrid::Block& block) {
    const auto* const leaf = block.leaf.get();
    if (!leaf) return;
    std::uint8_t rows[kLeafEdge * kLeafEdge];
    samples_within(leaf->data(), nearest, farthest, rows);
    // Box lo..hi of the samples with |distance| <= 2, relative to the leaf's origin. Sample (x, y, z) is bit 8y + z of
    // word x, in `rows` and in the mask.
    glm::ivec3 lo(kLeafEdge, 0, 0), hi(-1, 0, 0);
    std::uint64_t near = 0;
    for (int x = 0; x < kLeafEdge; ++x) {
      std::uint64_t bits;
      std::memcpy(&bits, rows + kLeafEdge * x, sizeof bits);
      bits &= leaf->on[static_cast<std::size_t>(x)];
      near |= bits;
      if (bits != 0) lo.x = std::min(lo.x, x), hi.x = x;
    }
    if (near == 0) return;
    lo.y = std::countr_zero(near) / kLeafEdge, hi.y = static_cast<int>(std::bit_width(near) - 1) / kLeafEdge;
    near |= near >> 32, near |= near >> 16, near |= near >> 8;
    near &= 0xff;
    lo.z = std::countr_zero(near), hi.z = static_cast<int>(std::bit_width(near) - 1);
    const glm::ivec3 origin = key * kLeafEdge;
    insert_bricks(origin + lo, origin + hi, keys);
  });
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
  typename Grid::Reader reader(grid);
  constexpr int n = kLeafEdge, side = FieldBrick::kSamples;
  static_assert(FieldBrick::kCells == 2 * n && side == 2 * n + 3);
  static constexpr int kFrom[4] = {n - 1, 0, 0, 0}, kCount[4] = {1, n, n, 2};
  const glm::ivec3 first = leaf_key(key * FieldBrick::kCells) - 1;
  Value tile[4][n];  // for each tile that replaces a leaf: n copies of the tile's value
  for (int i = 0; i < 4; ++i) {
    for (int j = 0; j < 4; ++j) {
      const Value* leaf[4];
      std::ptrdiff_t stride_x[4], stride_y[4];
      for (int k = 0; k < 4; ++k) {
        const auto& block = reader.block(first + glm::ivec3(i, j, k));
        if (block.leaf) {
          leaf[k] = block.leaf->data() + (kFrom[i] * n + kFrom[j]) * n;
          stride_x[k] = n * n, stride_y[k] = n;
        } else {
          std::fill_n(tile[k], n, block.tile);
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
  copy_brick(impl_->distance, key, brick.distance.data(), kDistance);
  if (has_surface(brick)) {
    copy_brick(impl_->tissue, key, brick.tissue.data(), [](std::int32_t value) { return shown_in(value); });
    brick.colored = impl_->colored;
    if (brick.colored) copy_brick(impl_->tissue, key, brick.color.data(), kColor);
  } else {
    brick.tissue.fill(Tissue::kAir);
    brick.colored = false;
  }
}

namespace {

/// For each tissue, sums (volume inside the surface × `weight`), m³. `weight`: function of the label grid's value.
template <class Weight>
PerTissue sum_volumes(const DistanceGrid& distance, const LabelGrid& labels, double voxel, const Weight& weight) {
  PerTissue volumes{};
  LabelGrid::Reader tissue(labels);
  const double voxel3 = voxel * voxel * voxel;
  distance.for_each_block([&](const glm::ivec3& key, const DistanceGrid::Block& block) {
    if (!block.leaf && fraction_inside(block.tile) == 0) return;
    const LabelGrid::Block& values = tissue.block(key);
    for (int i = 0; i < DistanceGrid::kSize; ++i) {
      const double fraction = fraction_inside(block.value(i));
      if (fraction == 0) continue;
      const std::int32_t value = values.value(i);
      volumes[static_cast<std::size_t>(shown_in(value))] += fraction * voxel3 * weight(value);
    }
  });
  volumes[0] = 0;
  return volumes;
}

}  // namespace

PerTissue TissueVolume::volumes() const {
  return sum_volumes(impl_->distance, impl_->tissue, impl_->frame.voxel, [](std::int32_t) { return 1.0; });
}

PerTissue TissueVolume::hardness_volumes() const {
  return sum_volumes(impl_->distance, impl_->tissue, impl_->frame.voxel,
                     [](std::int32_t value) { return hardness_fraction(hardness_in(value)); });
}

std::uint64_t TissueVolume::hash() const {
  Fnv1a hash;
  LabelGrid::Reader tissue(impl_->tissue);
  impl_->distance.for_each_block([&](const glm::ivec3& key, const DistanceGrid::Block& block) {
    if (!block.leaf) return;
    const glm::ivec3 origin = key * kLeafEdge;
    hash.bytes(&origin, sizeof origin);
    hash.bytes(block.leaf->data(), sizeof block.leaf->values);
    const LabelGrid::Block& labels = tissue.block(key);
    for (int i = 0; i < DistanceGrid::kSize; ++i) {
      if (!block.leaf->is_on(i)) continue;
      const int label = labels.value(i);
      hash.bytes(&label, sizeof label);
    }
  });
  return hash.value;
}

}  // namespace typodont::haptics
