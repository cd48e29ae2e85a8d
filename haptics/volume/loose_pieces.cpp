#include "haptics/volume/loose_pieces.h"

#include <algorithm>
#include <bit>
#include <numeric>
#include <set>
#include <tuple>

#include "haptics/tissue_volume.h"

namespace typodont::haptics {

namespace {

constexpr int kEdge = 8;
constexpr std::uint64_t kFirstZ = 0x0101010101010101, kLastZ = kFirstZ << 7;
// Limits of the search's work. kCreditPerCut: number of blocks that each cut adds to the credit, which is the number of
// blocks that may still be visited. kMostCredit: limit of the credit. A visit of a block takes about 1 µs.
constexpr std::int64_t kCreditPerCut = 200, kMostCredit = 100'000;

int floor_div(int a, int b) {
  return a >= 0 ? a / b : -((-a + b - 1) / b);
}
glm::ivec3 block_of(const glm::ivec3& voxel) {
  return {floor_div(voxel.x, kEdge), floor_div(voxel.y, kEdge), floor_div(voxel.z, kEdge)};
}
bool before(const glm::ivec3& a, const glm::ivec3& b) {
  return std::tie(a.x, a.y, a.z) < std::tie(b.x, b.y, b.z);
}

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

/// Returns the samples of `b`, and all samples of the block that share a face with one of them.
SolidBits grown(const SolidBits& b) {
  SolidBits out;
  for (std::size_t x = 0; x < 8; ++x) {
    const std::uint64_t w = b[x];
    out[x] = w | ((w << 1) & ~kFirstZ) | ((w >> 1) & ~kLastZ) | (w << 8) | (w >> 8) | (x > 0 ? b[x - 1] : 0) |
             (x < 7 ? b[x + 1] : 0);
  }
  return out;
}

/// Adds to word x of a part (the samples of one layer x) all samples of `solid` that are connected to the part within
/// this layer, or across a face from the adjacent layers.
void grow_word(SolidBits& part, const SolidBits& solid, std::size_t x) {
  std::uint64_t w = part[x] | (((x > 0 ? part[x - 1] : 0) | (x < 7 ? part[x + 1] : 0)) & solid[x]);
  for (std::uint64_t last = 0; w != last;) {
    last = w;
    w |= (((w << 1) & ~kFirstZ) | ((w >> 1) & ~kLastZ) | (w << 8) | (w >> 8)) & solid[x];
  }
  part[x] = w;
}

/// Calls `visit` for each connected part of a block.
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
      // The words are processed forward and backward, so that a few rounds complete the part.
      for (std::size_t i = 0; i < 8; ++i) grow_word(part, left, i);
      for (std::size_t i = 8; i-- > 0;) grow_word(part, left, i);
    }
    for (std::size_t i = 0; i < 8; ++i) left[i] &= ~part[i];
    visit(part);
  }
}

/// Returns the samples of the neighbouring block that touch the samples `b` over one face of the block. `face`: 0, 1:
/// ∓x; 2, 3: ∓y; 4, 5: ∓z.
SolidBits across(const SolidBits& b, int face) {
  SolidBits out{};
  for (std::size_t x = 0; x < 8; ++x) {
    if (face == 2) out[x] = (b[x] & 0xFF) << 56;
    if (face == 3) out[x] = b[x] >> 56;
    if (face == 4) out[x] = (b[x] & kFirstZ) << 7;
    if (face == 5) out[x] = (b[x] & kLastZ) >> 7;
  }
  if (face == 0) out[7] = b[0];
  if (face == 1) out[0] = b[7];
  return out;
}
glm::ivec3 neighbour(glm::ivec3 key, int face) {
  key[face / 2] += face % 2 ? 1 : -1;
  return key;
}

}  // namespace

/// The solid samples of the blocks as they were last read, linked to the neighbouring blocks, and the flood fills in
/// them. All floods spread at the same rate and are joined when they meet. The buffers stay allocated between cuts.
class LoosePieces::KnownBlocks {
 public:
  /// Returns the bits (1: solid sample) of a block as last read; the caller may change them. Null if the block was not
  /// read yet.
  SolidBits* seen(const glm::ivec3& key) {
    const auto it = index_.find(key);
    return it == index_.end() ? nullptr : &changing(it->second);
  }
  /// Returns the bits (1: solid sample) of a block as last read. A block that was not read yet is read now, and
  /// `unseen` becomes true.
  SolidBits& bits(const TissueVolume& volume, const glm::ivec3& key, bool* unseen = nullptr) {
    return changing(find(volume, key, unseen));
  }
  void forget() {
    index_.clear();
    blocks_.clear();
  }

  /// Begins a new search without floods.
  void begin_search() {
    ++look_;
    looked_at_ = 0;
    parts_.clear();
    flood_count_ = 0;
  }
  /// Starts a flood in each part of the block that contains a sample of `seeds`.
  void start(const TissueVolume& volume, const glm::ivec3& key, const SolidBits& seeds) {
    const Block& block = with_parts(find(volume, key, nullptr));
    for (int i = block.first_part; i < block.first_part + block.part_count; ++i) {
      const Part& part = parts_[static_cast<std::size_t>(i)];
      if (part.flood >= 0 || !overlap(part.bits, seeds)) continue;
      const int flood = flood_count_++;
      if (flood_count_ > static_cast<int>(floods_.size())) floods_.emplace_back();
      floods_[static_cast<std::size_t>(flood)].begin(flood);
      take(flood, i);
    }
  }
  /// Lets the floods (flood fills of connected tissue from the places of the cut) spread until at most one flood can
  /// still spread, and this flood is larger than all floods that ended.
  void run(const TissueVolume& volume) {
    roots_.resize(static_cast<std::size_t>(flood_count_));
    std::iota(roots_.begin(), roots_.end(), 0);
    for (;;) {
      std::erase_if(roots_, [&](int i) { return floods_[static_cast<std::size_t>(i)].root != i; });
      if (roots_.size() < 2) return;
      live_.clear();
      std::int64_t largest = 0;  // number of samples of the largest flood that has ended
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
  /// Returns the number of floods that remain separate.
  std::size_t apart() const { return roots_.size(); }
  /// Returns the tissue of each remaining flood, sorted by size. The last flood is the largest; it may be incomplete.
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
        piece.push_back({blocks_[static_cast<std::size_t>(part.block)].key, part.bits});
      }
      out.push_back(std::move(piece));
    }
    return out;
  }
  /// Returns the number of blocks that this search visited.
  std::int64_t looked_at() const { return looked_at_; }

 private:
  struct Block {
    glm::ivec3 key{0};
    SolidBits bits{};
    bool one_part = false;  // true if the samples of this block (its bits) are known to be connected
    // indices of the neighbouring blocks over the six faces; -1: not known yet
    int beside[6] = {-1, -1, -1, -1, -1, -1};
    // Number of the last search that visited this block; `first_part` and `part_count` belong to that search
    std::uint32_t look = 0;
    int first_part = 0, part_count = 0;  // range of indices: the block's connected parts in parts_
  };
  struct Part {
    SolidBits bits{};
    int block = 0, flood = -1;
  };
  struct Flood {
    int root = 0;
    std::vector<int> edge;  // parts from which the flood spreads; parts before index `next` are done
    std::size_t next = 0;
    std::vector<int> taken;  // indices of the flood's parts
    std::int64_t samples = 0;
    void begin(int number) {
      root = number;
      edge.clear(), taken.clear();
      next = 0, samples = 0;
    }
    bool ended() const { return next == edge.size(); }
  };

  SolidBits& changing(int block) {
    blocks_[static_cast<std::size_t>(block)].one_part = false;
    return blocks_[static_cast<std::size_t>(block)].bits;
  }
  int find(const TissueVolume& volume, const glm::ivec3& key, bool* unseen) {
    const auto [it, fresh] = index_.try_emplace(key, static_cast<int>(blocks_.size()));
    if (fresh) {
      Block& block = blocks_.emplace_back();
      block.key = key;
      volume.solid_block(key, block.bits);
    }
    if (unseen) *unseen = fresh;
    return it->second;
  }
  int find_beside(const TissueVolume& volume, int block, int face) {
    const int known = blocks_[static_cast<std::size_t>(block)].beside[face];
    if (known >= 0) return known;
    const int next = find(volume, neighbour(blocks_[static_cast<std::size_t>(block)].key, face), nullptr);
    blocks_[static_cast<std::size_t>(block)].beside[face] = next;
    blocks_[static_cast<std::size_t>(next)].beside[face ^ 1] = block;
    return next;
  }
  const Block& with_parts(int index) {
    Block& block = blocks_[static_cast<std::size_t>(index)];
    if (block.look == look_) return block;
    block.look = look_;
    ++looked_at_;
    block.first_part = static_cast<int>(parts_.size());
    if (block.one_part) {
      parts_.push_back({block.bits, index, -1});
    } else {
      for_each_part(block.bits, [&](const SolidBits& bits) { parts_.push_back({bits, index, -1}); });
    }
    block.part_count = static_cast<int>(parts_.size()) - block.first_part;
    block.one_part = block.part_count == 1;
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
    f.samples += count(parts_[static_cast<std::size_t>(part)].bits);
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
    for (int face = 0; face < 6; ++face) {
      const SolidBits touched = across(part.bits, face);
      if (!any(touched)) continue;
      const Block& next = with_parts(find_beside(volume, part.block, face));
      for (int i = next.first_part; i < next.first_part + next.part_count; ++i) {
        const Part& beside = parts_[static_cast<std::size_t>(i)];
        if (!overlap(beside.bits, touched)) continue;
        if (beside.flood < 0) {
          take(flood, i);
        } else if (const int other = root_of(beside.flood); other != flood) {
          flood = join(flood, other);
        }
      }
    }
  }

  std::unordered_map<glm::ivec3, int, KeyHash> index_;
  std::vector<Block> blocks_;
  std::uint32_t look_ = 0;
  std::int64_t looked_at_ = 0;
  std::vector<Part> parts_;  // the connected parts of blocks that this search has found, block by block
  std::vector<Flood> floods_;
  int flood_count_ = 0;  // number of floods in use
  std::vector<int> roots_, live_;
};

LoosePieces::LoosePieces(const TissueVolume& volume) : blocks_(std::make_unique<KnownBlocks>()) {
  glm::ivec3 lo, hi;
  volume.bounds(lo, hi);
  if (lo.x > hi.x) return;
  blocks_->begin_search();
  const glm::ivec3 first = block_of(lo), last = block_of(hi);
  for (int x = first.x; x <= last.x; ++x) {
    for (int y = first.y; y <= last.y; ++y) {
      for (int z = first.z; z <= last.z; ++z) {
        const SolidBits bits = blocks_->bits(volume, {x, y, z});
        if (any(bits)) blocks_->start(volume, {x, y, z}, bits);
      }
    }
  }
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

/// Compares a block with its last reading, and stores the samples that became air.
void LoosePieces::note_emptied(const TissueVolume& volume, const glm::ivec3& key) {
  bool unseen;
  SolidBits& seen = blocks_->bits(volume, key, &unseen);
  SolidBits now = seen, gone;
  if (!unseen) volume.solid_block(key, now);
  // For a block that was not read since the last edit, any sample that is air now may have been tissue.
  for (std::size_t i = 0; i < 8; ++i) gone[i] = unseen ? ~now[i] : seen[i] & ~now[i];
  seen = now;
  if (any(gone)) emptied_.push_back({key, gone});
}

std::vector<TissuePiece> LoosePieces::after_cut(const TissueVolume& volume, const VoxelBox& written,
                                                std::span<const glm::ivec3> blocks) {
  const glm::ivec3 lo = block_of(written.lo), hi = block_of(written.hi);
  if (!(glm::all(glm::greaterThanEqual(lo, all_seen_lo_)) && glm::all(glm::lessThanEqual(hi, all_seen_hi_)))) {
    for (int x = lo.x; x <= hi.x; ++x) {
      for (int y = lo.y; y <= hi.y; ++y) {
        for (int z = lo.z; z <= hi.z; ++z) {
          if (!blocks_->seen({x, y, z})) note_emptied(volume, {x, y, z});
        }
      }
    }
    all_seen_lo_ = lo, all_seen_hi_ = hi;
  }
  for (const glm::ivec3& key : blocks) note_emptied(volume, key);
  credit_ = std::min(credit_ + kCreditPerCut, kMostCredit);
  if (emptied_.empty() || credit_ <= 0) return {};

  std::sort(emptied_.begin(), emptied_.end(),
            [](const BlockPart& a, const BlockPart& b) { return before(a.key, b.key); });
  blocks_->begin_search();
  for (auto part = emptied_.begin(); part != emptied_.end();) {
    const glm::ivec3 key = part->key;
    SolidBits gone{};  // samples emptied by all cuts since the last search
    for (; part != emptied_.end() && part->key == key; ++part) {
      for (std::size_t i = 0; i < 8; ++i) gone[i] |= part->bits[i];
    }
    blocks_->start(volume, key, grown(gone));
    for (int face = 0; face < 6; ++face) {
      const SolidBits beside = across(gone, face);
      if (any(beside)) blocks_->start(volume, neighbour(key, face), beside);
    }
  }
  emptied_.clear();
  blocks_->run(volume);
  credit_ -= blocks_->looked_at();
  if (blocks_->apart() < 2) return {};
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
  const glm::ivec3 first = block_of(lo), last = block_of(hi);
  for (int x = first.x; x <= last.x; ++x) {
    for (int y = first.y; y <= last.y; ++y) {
      for (int z = first.z; z <= last.z; ++z) {
        volume.solid_block({x, y, z}, blocks_->bits(volume, {x, y, z}));
      }
    }
  }
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
