#include "haptics/volume/loose_pieces.h"

#include <algorithm>
#include <bit>
#include <numeric>
#include <set>

#include "engine/base/voxels.h"
#include "haptics/tissue_volume.h"
#include "haptics/volume/leaf_key.h"

namespace typodont::haptics {

namespace {

constexpr std::uint64_t kFirstZ = 0x0101010101010101, kLastZ = kFirstZ << 7;
// Number of blocks that searches may visit: increase per cut, and upper limit. A visit takes about 1 µs.
constexpr std::int64_t kCreditPerCut = 200, kMaxCredit = 100'000;

bool any(const SolidBits& b) {
  return (b[0] | b[1] | b[2] | b[3] | b[4] | b[5] | b[6] | b[7]) != 0;
}
bool overlap(const SolidBits& a, const SolidBits& b) {
  std::uint64_t both = 0;
  for (std::size_t x = 0; x < 8; ++x) both |= a[x] & b[x];
  return both != 0;
}
std::int64_t count(const SolidBits& b) {
  std::int64_t n = 0;
  for (const std::uint64_t word : b) n += std::popcount(word);
  return n;
}

/// Returns the given samples, and all samples of the block that share a face with one of them.
SolidBits grown(const SolidBits& b) {
  SolidBits out;
  for (std::size_t x = 0; x < 8; ++x) {
    const std::uint64_t w = b[x];
    out[x] = w | ((w << 1) & ~kFirstZ) | ((w >> 1) & ~kLastZ) | (w << 8) | (w >> 8) | (x > 0 ? b[x - 1] : 0) |
             (x < 7 ? b[x + 1] : 0);
  }
  return out;
}

/// Grows `part` in layer x: first by samples beside those of `part` in layers x ± 1, then by all connected samples.
void grow_word(SolidBits& part, const SolidBits& solid, std::size_t x) {
  std::uint64_t w = part[x] | (((x > 0 ? part[x - 1] : 0) | (x < 7 ? part[x + 1] : 0)) & solid[x]);
  for (std::uint64_t last = 0; w != last;) {
    last = w;
    w |= (((w << 1) & ~kFirstZ) | ((w >> 1) & ~kLastZ) | (w << 8) | (w >> 8)) & solid[x];
  }
  part[x] = w;
}

/// Calls visit() for each connected part of a block.
template <class Visit>
void for_each_part(const SolidBits& solid, Visit&& visit) {
  std::uint64_t all = ~std::uint64_t{0};
  for (const std::uint64_t word : solid) all &= word;
  if (all == ~std::uint64_t{0}) {
    visit(solid);
    return;
  }
  SolidBits left = solid;
  for (std::size_t x = 0; x < 8;) {
    if (left[x] == 0) {
      ++x;
      continue;
    }
    SolidBits part{};
    part[x] = left[x] & (~left[x] + 1);
    for (SolidBits last{}; part != last;) {
      last = part;
      // Grows the part forward and backward, in a few rounds. Usually all samples are connected, so that the first
      // forward growth reaches all samples.
      for (std::size_t i = 0; i < 8; ++i) grow_word(part, left, i);
      if (part == left) break;
      for (std::size_t i = 8; i-- > 0;) grow_word(part, left, i);
    }
    for (std::size_t i = 0; i < 8; ++i) left[i] &= ~part[i];
    visit(part);
  }
}

/// Samples on each face of a block (first and last x, y, z), and number of samples. Where two blocks touch,
/// samples that touch each other have the same bit.
struct Shape {
  std::array<std::uint64_t, 6> faces{};
  std::int64_t samples = 0;
};

std::array<std::uint64_t, 6> faces_of(const SolidBits& b) {
  // Returns one byte that consists of the lowest bits of the eight bytes of `word`.
  const auto lowest = [](std::uint64_t word) { return (word & kFirstZ) * 0x0102040810204080 >> 56; };
  std::array<std::uint64_t, 6> faces{b[0], b[7]};
  for (std::size_t x = 0; x < 8; ++x) {
    faces[2] |= (b[x] & 0xFF) << 8 * x;
    faces[3] |= (b[x] >> 56) << 8 * x;
    faces[4] |= lowest(b[x]) << 8 * x;
    faces[5] |= lowest(b[x] >> 7) << 8 * x;
  }
  return faces;
}
Shape shape_of(const SolidBits& b) {
  return {faces_of(b), count(b)};
}
glm::ivec3 neighbour(glm::ivec3 key, int face) {
  key[face / 2] += face % 2 ? 1 : -1;
  return key;
}

}  // namespace

/// The blocks (8³ samples) as last read, their neighbours, and the flood fills in them. Buffers are kept between cuts.
class LoosePieces::KnownBlocks {
 public:
  /// Samples of a block, which the caller may change; null: the block has not been read yet.
  SolidBits* seen(const glm::ivec3& key) {
    const auto it = index_.find(key);
    return it == index_.end() ? nullptr : &changing(it->second);
  }
  /// Returns the index of a block, and reads the block if that is necessary. `unseen`: set to true in this case.
  int find(const TissueVolume& volume, const glm::ivec3& key, bool* unseen = nullptr) {
    const auto [it, fresh] = index_.try_emplace(key, static_cast<int>(blocks_.size()));
    if (fresh) {
      blocks_.emplace_back();
      keys_.push_back(key);
      volume.solid_block(key, bits_.emplace_back());
    }
    if (unseen) *unseen = fresh;
    return it->second;
  }
  /// Samples of a block, which the caller may change.
  SolidBits& changing(int block) {
    blocks_[static_cast<std::size_t>(block)].one_part = false;
    return bits_[static_cast<std::size_t>(block)];
  }
  void forget() {
    index_.clear();
    blocks_.clear(), keys_.clear(), bits_.clear();
  }

  const glm::ivec3& key(int block) const { return keys_[static_cast<std::size_t>(block)]; }

  /// Begins a search without any flood fill.
  void begin_search() {
    ++search_;
    examined_ = 0;
    parts_.clear(), part_bits_.clear(), part_shapes_.clear();
    flood_count_ = 0;
    cut_blocks_.clear(), touches_.clear();
  }
  /// Starts a flood fill in each part of the block.
  void start(int block) {
    start_in(block, [](const Part&) { return true; });
  }
  /// Starts a flood fill in each part that touches `gone`, the samples of `block` that became air.
  void start_around(const TissueVolume& volume, int block, const SolidBits& gone) {
    const SolidBits around = grown(gone);
    const std::array<std::uint64_t, 6> faces = faces_of(gone);
    cut_blocks_.emplace_back(block, static_cast<int>(cut_blocks_.size()), -1, faces);
    start_in(block, [&](const Part& part) { return overlap(bits_of(part), around); });
    for (std::size_t face = 0; face < 6; ++face) {
      if (faces[face] == 0) continue;
      start_in(find_beside(volume, block, face),
               [&](const Part& part) { return (shape_of(part).faces[face ^ 1] & faces[face]) != 0; });
    }
  }
  /// Returns true if nothing was separated: the tissue around each group of emptied samples is connected, so paths can
  /// lead around the group. This is the usual case, and needs no flood fill.
  bool connected_around_each_group(const TissueVolume& volume) {
    join_touching_floods(volume);
    join_touching_cut_blocks();
    for (const Touch& touch : touches_) {
      int& flood = cut_blocks_[static_cast<std::size_t>(group_of(touch.cut_block))].flood;
      const int root = root_of(touch.flood);
      if (flood >= 0 && flood != root) return false;
      flood = root;
    }
    return true;
  }
  /// Grows the floods until none can grow, or only one can, and this one is already larger than all ended floods.
  void run(const TissueVolume& volume) {
    roots_.resize(static_cast<std::size_t>(flood_count_));
    std::iota(roots_.begin(), roots_.end(), 0);
    for (;;) {
      std::erase_if(roots_, [&](int i) { return floods_[static_cast<std::size_t>(i)].root != i; });
      if (roots_.size() < 2) return;
      live_.clear();
      std::int64_t largest = 0;  // samples of the largest flood that has ended
      for (const int i : roots_) {
        const Flood& flood = floods_[static_cast<std::size_t>(i)];
        if (flood.ended()) {
          largest = std::max(largest, flood.samples);
        } else {
          live_.push_back(i);
        }
      }
      if (live_.empty()) return;
      if (live_.size() == 1 && floods_[static_cast<std::size_t>(live_[0])].samples > largest) return;
      for (const int i : live_) spread(volume, i);
    }
  }
  /// Number of separate floods; those that have met count once.
  std::size_t apart() const { return roots_.size(); }
  /// Pieces that the floods have filled, the smallest first. The last and largest piece may be incomplete.
  std::vector<TissuePiece> pieces() const {
    std::vector<const Flood*> order;
    for (const int i : roots_) order.push_back(&floods_[static_cast<std::size_t>(i)]);
    std::stable_sort(order.begin(), order.end(),
                     [](const Flood* a, const Flood* b) { return a->samples < b->samples; });
    std::vector<TissuePiece> out;
    for (const Flood* flood : order) {
      TissuePiece piece;
      for (const int i : flood->taken) {
        const Part& part = parts_[static_cast<std::size_t>(i)];
        piece.push_back({key(part.block), bits_of(part)});
      }
      out.push_back(std::move(piece));
    }
    return out;
  }
  /// Number of blocks of 8³ samples that this search has visited.
  std::int64_t examined() const { return examined_; }

 private:
  /// Data of every visited block, at most two cache lines. keys_ and bits_ store its key and samples, which are needed
  /// for few blocks.
  struct alignas(32) Block {
    // number of the last search that visited the block; this search has set the other members
    std::uint32_t search = 0;
    int first_part = 0, part_count = 0;  // range of the block's parts in parts_
    // neighbours over the six faces; -1: not known
    int beside[6] = {-1, -1, -1, -1, -1, -1};
    bool one_part = false;  // true: the samples are known to be connected
    Shape whole;            // valid if `one_part`
  };
  static_assert(sizeof(Block) == 96);
  struct Part {
    int block = 0, flood = -1;
    int own = -1;  // index in part_bits_; -1: the part contains all samples of the block
  };
  struct Flood {
    int root = 0;
    std::vector<int> edge;  // parts at which the flood fill grows; those before `next` are done
    std::size_t next = 0;
    std::vector<int> taken;  // indices of the parts that the flood fill has reached
    std::int64_t samples = 0;
    void begin(int number) {
      root = number;
      edge.clear(), taken.clear();
      next = 0, samples = 0;
    }
    bool ended() const { return next == edge.size(); }
  };

  /// A block in which samples became air.
  struct CutBlock {
    int block;
    // Next block of the group (union-find); own index: this block represents the group.
    int group;
    int flood;                           // index of the flood fill around the group; -1: not known
    std::array<std::uint64_t, 6> faces;  // samples on the block's faces that became air
  };
  /// Records that emptied samples touch the part in which a flood fill began.
  struct Touch {
    int cut_block, flood;
  };

  const SolidBits& bits_of(const Part& part) const {
    return part.own < 0 ? bits_[static_cast<std::size_t>(part.block)] : part_bits_[static_cast<std::size_t>(part.own)];
  }
  const Shape& shape_of(const Part& part) const {
    return part.own < 0 ? blocks_[static_cast<std::size_t>(part.block)].whole
                        : part_shapes_[static_cast<std::size_t>(part.own)];
  }
  template <class Touched>
  void start_in(int index, const Touched& touched) {
    const Block& block = with_parts(index);
    for (int i = block.first_part; i < block.first_part + block.part_count; ++i) {
      const Part& part = parts_[static_cast<std::size_t>(i)];
      if (!touched(part)) continue;
      if (part.flood < 0) {
        const int flood = flood_count_++;
        if (flood_count_ > static_cast<int>(floods_.size())) floods_.emplace_back();
        floods_[static_cast<std::size_t>(flood)].begin(flood);
        take(flood, i);
      }
      if (!cut_blocks_.empty()) touches_.emplace_back(static_cast<int>(cut_blocks_.size()) - 1, part.flood);
    }
  }
  /// Joins flood fills whose parts touch.
  void join_touching_floods(const TissueVolume& volume) {
    for (std::size_t i = 0; i < parts_.size(); ++i) {
      const Part part = parts_[i];
      if (part.flood < 0) continue;
      const std::array<std::uint64_t, 6> faces = shape_of(part).faces;
      // Tests each pair of blocks only once.
      for (std::size_t face = 1; face < 6; face += 2) {
        if (faces[face] == 0) continue;
        const Block& next = blocks_[static_cast<std::size_t>(find_beside(volume, part.block, face))];
        if (next.search != search_) continue;
        for (int j = next.first_part; j < next.first_part + next.part_count; ++j) {
          const Part& beside = parts_[static_cast<std::size_t>(j)];
          if (beside.flood < 0 || (shape_of(beside).faces[face ^ 1] & faces[face]) == 0) continue;
          const int a = root_of(part.flood), b = root_of(beside.flood);
          if (a != b) join(a, b);
        }
      }
    }
  }
  /// Joins cut blocks whose emptied samples touch.
  void join_touching_cut_blocks() {
    cut_block_in_.resize(blocks_.size());
    for (std::size_t i = 0; i < cut_blocks_.size(); ++i)
      cut_block_in_[static_cast<std::size_t>(cut_blocks_[i].block)] = static_cast<int>(i);
    for (std::size_t i = 0; i < cut_blocks_.size(); ++i) {
      const CutBlock& cut = cut_blocks_[i];
      for (std::size_t face = 1; face < 6; face += 2) {
        if (cut.faces[face] == 0) continue;
        const int next = blocks_[static_cast<std::size_t>(cut.block)].beside[face];
        // This index may be left over from an earlier search, so it is checked.
        const auto j = static_cast<std::size_t>(cut_block_in_[static_cast<std::size_t>(next)]);
        if (j >= cut_blocks_.size() || cut_blocks_[j].block != next) continue;
        if ((cut_blocks_[j].faces[face ^ 1] & cut.faces[face]) == 0) continue;
        const int a = group_of(static_cast<int>(i)), b = group_of(static_cast<int>(j));
        cut_blocks_[static_cast<std::size_t>(a)].group = b;
      }
    }
  }
  int group_of(int cut_block) const {
    while (cut_blocks_[static_cast<std::size_t>(cut_block)].group != cut_block)
      cut_block = cut_blocks_[static_cast<std::size_t>(cut_block)].group;
    return cut_block;
  }
  int find_beside(const TissueVolume& volume, int block, std::size_t face) {
    const int known = blocks_[static_cast<std::size_t>(block)].beside[face];
    if (known >= 0) return known;
    const int next = find(volume, neighbour(key(block), static_cast<int>(face)));
    blocks_[static_cast<std::size_t>(block)].beside[face] = next;
    blocks_[static_cast<std::size_t>(next)].beside[face ^ 1] = block;
    return next;
  }
  const Block& with_parts(int index) {
    Block& block = blocks_[static_cast<std::size_t>(index)];
    if (block.search == search_) return block;
    block.search = search_;
    ++examined_;
    block.first_part = static_cast<int>(parts_.size());
    if (!block.one_part) {
      for_each_part(bits_[static_cast<std::size_t>(index)], [&](const SolidBits& bits) {
        parts_.emplace_back(index, -1, static_cast<int>(part_bits_.size()));
        part_bits_.push_back(bits), part_shapes_.push_back(typodont::haptics::shape_of(bits));
      });
      block.part_count = static_cast<int>(parts_.size()) - block.first_part;
      if (block.part_count != 1) return block;
      block.one_part = true;
      block.whole = part_shapes_.back();
      parts_.pop_back(), part_bits_.pop_back(), part_shapes_.pop_back();
    }
    parts_.emplace_back(index);
    block.part_count = 1;
    return block;
  }
  int root_of(int flood) const {
    while (floods_[static_cast<std::size_t>(flood)].root != flood)
      flood = floods_[static_cast<std::size_t>(flood)].root;
    return flood;
  }
  void take(int flood, int part) {
    parts_[static_cast<std::size_t>(part)].flood = flood;
    Flood& f = floods_[static_cast<std::size_t>(flood)];
    f.edge.push_back(part);
    f.taken.push_back(part);
    f.samples += shape_of(parts_[static_cast<std::size_t>(part)]).samples;
  }
  int join(int a, int b) {
    Flood* to = &floods_[static_cast<std::size_t>(a)];
    Flood* from = &floods_[static_cast<std::size_t>(b)];
    if (to->taken.size() < from->taken.size()) std::swap(to, from), std::swap(a, b);
    to->edge.insert(to->edge.end(), from->edge.begin() + static_cast<std::ptrdiff_t>(from->next), from->edge.end());
    to->taken.insert(to->taken.end(), from->taken.begin(), from->taken.end());
    to->samples += from->samples;
    from->root = a;
    return a;
  }
  void spread(const TissueVolume& volume, int flood) {
    flood = root_of(flood);
    Flood& f = floods_[static_cast<std::size_t>(flood)];
    if (f.ended()) return;
    const Part part = parts_[static_cast<std::size_t>(f.edge[f.next++])];
    // a copy, because with_parts() may move the shapes in memory
    const std::array<std::uint64_t, 6> faces = shape_of(part).faces;
    // Prefetches all neighbours, because a search mostly waits for memory.
    for (const int beside : blocks_[static_cast<std::size_t>(part.block)].beside) {
      const auto* const next = reinterpret_cast<const char*>(blocks_.data() + std::max(beside, 0));
      __builtin_prefetch(next), __builtin_prefetch(next + sizeof(Block) - 1);
    }
    for (std::size_t face = 0; face < 6; ++face) {
      if (faces[face] == 0) continue;
      const Block& next = with_parts(find_beside(volume, part.block, face));
      for (int i = next.first_part; i < next.first_part + next.part_count; ++i) {
        const Part& beside = parts_[static_cast<std::size_t>(i)];
        if ((shape_of(beside).faces[face ^ 1] & faces[face]) == 0) continue;
        if (beside.flood < 0) {
          take(flood, i);
        } else if (const int other = root_of(beside.flood); other != flood) {
          flood = join(flood, other);
        }
      }
    }
  }

  std::unordered_map<glm::ivec3, int, KeyHash> index_;
  // blocks_, keys_ and bits_ have the same indices; the first sample of a block is at 8·key
  std::vector<Block> blocks_;
  std::vector<glm::ivec3> keys_;
  std::vector<SolidBits> bits_;
  std::uint32_t search_ = 0;
  std::int64_t examined_ = 0;
  std::vector<Part> parts_;  // parts of this search, block by block
  // Samples and shapes of parts that do not fill their block.
  std::vector<SolidBits> part_bits_;
  std::vector<Shape> part_shapes_;
  std::vector<Flood> floods_;
  int flood_count_ = 0;  // number of floods in use
  std::vector<int> roots_, live_;
  std::vector<CutBlock> cut_blocks_;
  std::vector<Touch> touches_;
  std::vector<int> cut_block_in_;  // for each block: its index in cut_blocks_ in the last search
};

LoosePieces::LoosePieces(const TissueVolume& volume) : blocks_(std::make_unique<KnownBlocks>()) {
  glm::ivec3 lo, hi;
  volume.bounds(lo, hi);
  if (lo.x > hi.x) return;
  blocks_->begin_search();
  const glm::ivec3 first = leaf_key(lo), last = leaf_key(hi);
  for_each_voxel_between(first, last, [&](int x, int y, int z) {
    const int block = blocks_->find(volume, {x, y, z});
    blocks_->start(block);
  });
  blocks_->run(volume);
  std::vector<TissuePiece> bodies = blocks_->pieces();
  body_count_ = bodies.size();
  if (!bodies.empty()) bodies.pop_back();
  int number = 0;
  for (const TissuePiece& body : bodies) {
    ++number;
    for (const BlockPart& part : body) bodies_[part.key].push_back({part.bits, number});
  }
}

LoosePieces::~LoosePieces() = default;

/// Stores samples that were emptied since the block was last read. `now`: current samples in tissue.
void LoosePieces::note_emptied(int block, const SolidBits& now, bool unseen) {
  SolidBits& seen = blocks_->changing(block);
  SolidBits gone;
  // Samples that were tissue when last read, and are air now. In a block that was not read since an edit, any air may
  // have been tissue.
  for (std::size_t i = 0; i < 8; ++i) gone[i] = unseen ? ~now[i] : seen[i] & ~now[i];
  seen = now;
  if (any(gone)) emptied_.push_back({{blocks_->key(block), gone}, block});
}

std::vector<TissuePiece> LoosePieces::after_cut(const TissueVolume& volume, const VoxelBox& written,
                                                std::span<const BlockPart> blocks) {
  const glm::ivec3 lo = leaf_key(written.lo), hi = leaf_key(written.hi);
  if (!(glm::all(glm::greaterThanEqual(lo, all_seen_lo_)) && glm::all(glm::lessThanEqual(hi, all_seen_hi_)))) {
    for (int x = lo.x; x <= hi.x; ++x) {
      for (int y = lo.y; y <= hi.y; ++y) {
        // Skips blocks in the box all_seen_lo_ to all_seen_hi_, which were already read, because find() is slow.
        const bool beside = x < all_seen_lo_.x || x > all_seen_hi_.x || y < all_seen_lo_.y || y > all_seen_hi_.y;
        for (int z = lo.z; z <= hi.z; ++z) {
          if (!beside && z >= all_seen_lo_.z && z <= all_seen_hi_.z) {
            z = all_seen_hi_.z;
            continue;
          }
          bool unseen;
          const int block = blocks_->find(volume, {x, y, z}, &unseen);
          if (unseen) note_emptied(block, SolidBits(blocks_->changing(block)), true);
        }
      }
    }
    all_seen_lo_ = lo, all_seen_hi_ = hi;
  }
  for (const BlockPart& now : blocks) note_emptied(blocks_->find(volume, now.key), now.bits, false);
  credit_ = std::min(credit_ + kCreditPerCut, kMaxCredit);
  if (emptied_.empty() || credit_ <= 0) return {};

  const auto by_key = [](const Emptied& a, const Emptied& b) { return LessByAxes{}(a.part.key, b.part.key); };
  // Blocks are usually visited in the order of their keys, so usually nothing must be sorted.
  if (!std::is_sorted(emptied_.begin(), emptied_.end(), by_key)) std::sort(emptied_.begin(), emptied_.end(), by_key);
  blocks_->begin_search();
  for (auto next = emptied_.begin(); next != emptied_.end();) {
    const int block = next->block;
    SolidBits gone{};  // samples emptied since the last search
    for (; next != emptied_.end() && next->block == block; ++next) {
      for (std::size_t i = 0; i < 8; ++i) gone[i] |= next->part.bits[i];
    }
    blocks_->start_around(volume, block, gone);
  }
  emptied_.clear();
  // No flood fill is needed if the tissue around each group of emptied samples is connected.
  const bool connected = blocks_->connected_around_each_group(volume);
  if (!connected) blocks_->run(volume);
  credit_ -= blocks_->examined();
  if (connected || blocks_->apart() < 2) return {};
  const std::vector<TissuePiece> found = blocks_->pieces();
  std::vector<TissuePiece> loose;
  for (std::size_t i = 0; i < found.size(); ++i) {
    const auto larger = found.begin() + static_cast<std::ptrdiff_t>(i) + 1;
    if (std::any_of(larger, found.end(), [&](const TissuePiece& other) { return same_body(found[i], other); })) {
      loose.push_back(found[i]);
    }
  }
  return loose;
}

void LoosePieces::after_fill(const TissueVolume& volume, const glm::ivec3& lo, const glm::ivec3& hi) {
  const glm::ivec3 first = leaf_key(lo), last = leaf_key(hi);
  for_each_voxel_between(first, last, [&](int x, int y, int z) {
    volume.solid_block({x, y, z}, blocks_->changing(blocks_->find(volume, {x, y, z})));
  });
}

void LoosePieces::after_edit() {
  blocks_->forget();
  all_seen_lo_ = glm::ivec3(0), all_seen_hi_ = glm::ivec3(-1);
  emptied_.clear();
}

void LoosePieces::removed(std::span<const TissuePiece> pieces) {
  for (const TissuePiece& piece : pieces) {
    for (const BlockPart& part : piece) {
      SolidBits* const bits = blocks_->seen(part.key);
      for (std::size_t i = 0; bits && i < 8; ++i) (*bits)[i] &= ~part.bits[i];
    }
  }
}

std::vector<int> LoosePieces::bodies_of(const TissuePiece& piece) const {
  std::set<int> numbers;
  for (const BlockPart& part : piece) {
    SolidBits rest = part.bits;
    if (const auto it = bodies_.find(part.key); it != bodies_.end()) {
      for (const Body& body : it->second) {
        if (overlap(part.bits, body.bits)) numbers.insert(body.number);
        for (std::size_t i = 0; i < 8; ++i) rest[i] &= ~body.bits[i];
      }
    }
    if (any(rest)) numbers.insert(0);
  }
  return {numbers.begin(), numbers.end()};
}

bool LoosePieces::same_body(const TissuePiece& a, const TissuePiece& b) const {
  if (bodies_.empty()) return true;
  const std::vector<int> mine = bodies_of(a), theirs = bodies_of(b);
  return std::find_first_of(mine.begin(), mine.end(), theirs.begin(), theirs.end()) != mine.end();
}

}  // namespace typodont::haptics
