#include "haptics/volume/loose_pieces.h"

#include <algorithm>
#include <bit>
#include <deque>
#include <set>
#include <tuple>

#include "haptics/tissue_volume.h"

namespace typodont::haptics {

namespace {

constexpr int kEdge = 8;
constexpr std::uint64_t kFirstZ = 0x0101010101010101, kLastZ = kFirstZ << 7;
constexpr std::int64_t kCreditPerCut = 200, kMostCredit = 100'000;  // blocks, about a microsecond each

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

/// Those samples and their neighbours over faces, within the block.
SolidBits grown(const SolidBits& b) {
  SolidBits out;
  for (std::size_t x = 0; x < 8; ++x) {
    const std::uint64_t w = b[x];
    out[x] = w | ((w << 1) & ~kFirstZ) | ((w >> 1) & ~kLastZ) | (w << 8) | (w >> 8) | (x > 0 ? b[x - 1] : 0) |
             (x < 7 ? b[x + 1] : 0);
  }
  return out;
}

/// The parts of a block that hang together within it.
std::vector<SolidBits> parts_of(const SolidBits& solid) {
  std::vector<SolidBits> parts;
  SolidBits left = solid;
  std::uint64_t all = ~std::uint64_t{0};
  for (const std::uint64_t word : solid) all &= word;
  if (all == ~std::uint64_t{0}) return {solid};
  for (std::size_t x = 0; x < 8;) {
    if (left[x] == 0) {
      ++x;
      continue;
    }
    SolidBits part{};
    part[x] = left[x] & (~left[x] + 1);
    for (SolidBits last{}; part != last;) {
      last = part;
      part = grown(part);
      for (std::size_t i = 0; i < 8; ++i) part[i] &= left[i];
    }
    for (std::size_t i = 0; i < 8; ++i) left[i] &= ~part[i];
    parts.push_back(part);
  }
  return parts;
}

/// What of a block touches the neighbour in direction `face` (0, 1: ∓x; 2, 3: ∓y; 4, 5: ∓z), as samples of that
/// neighbour.
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

/// Floods that spread at the same pace and are one from where they meet.
class LoosePieces::Floods {
 public:
  Floods(LoosePieces& pieces, const TissueVolume& volume) : pieces_(pieces), volume_(volume) {}

  /// A flood from each part of the block that holds any of `seeds`.
  void start(const glm::ivec3& key, const SolidBits& seeds) {
    std::vector<Part>& parts = parts_at(key);
    for (std::size_t i = 0; i < parts.size(); ++i) {
      if (parts[i].flood >= 0 || !overlap(parts[i].bits, seeds)) continue;
      const int flood = static_cast<int>(floods_.size());
      floods_.push_back({flood, {}, {}, 0});
      take(flood, key, i);
    }
  }

  /// Lets them spread until no more than one has anywhere to go, and that one is larger than all that ended.
  void run() {
    for (;;) {
      std::vector<int> live, ended;
      for (int i = 0; i < static_cast<int>(floods_.size()); ++i) {
        const Flood& flood = floods_[static_cast<std::size_t>(i)];
        if (flood.root == i) (flood.edge.empty() ? ended : live).push_back(i);
      }
      if (live.size() + ended.size() < 2 || live.empty()) return;
      std::int64_t largest = 0;
      for (const int i : ended) largest = std::max(largest, floods_[static_cast<std::size_t>(i)].samples);
      if (live.size() == 1 && floods_[static_cast<std::size_t>(live[0])].samples > largest) return;
      for (const int i : live) spread(i);
    }
  }

  /// All that went round something, and the rest (last) as far as it was seen; the largest is the last.
  std::vector<TissuePiece> pieces() {
    std::vector<const Flood*> roots;
    for (int i = 0; i < static_cast<int>(floods_.size()); ++i) {
      if (floods_[static_cast<std::size_t>(i)].root == i) roots.push_back(&floods_[static_cast<std::size_t>(i)]);
    }
    std::stable_sort(roots.begin(), roots.end(),
                     [](const Flood* a, const Flood* b) { return a->samples < b->samples; });
    std::vector<TissuePiece> out;
    for (const Flood* root : roots) {
      TissuePiece piece;
      for (const auto& [key, index] : root->taken) piece.push_back({key, parts_at(key)[index].bits});
      out.push_back(std::move(piece));
    }
    return out;
  }
  std::int64_t looked_at() const { return static_cast<std::int64_t>(parts_.size()); }

 private:
  struct Part {
    SolidBits bits{};
    int flood = -1;
  };
  using Place = std::pair<glm::ivec3, std::size_t>;  // a part of a block
  struct Flood {
    int root;
    std::deque<Place> edge;  // to spread from
    std::vector<Place> taken;
    std::int64_t samples;
  };

  std::vector<Part>& parts_at(const glm::ivec3& key) {
    const auto [it, fresh] = parts_.try_emplace(key);
    if (fresh) {
      for (const SolidBits& bits : parts_of(pieces_.solid(volume_, key))) it->second.push_back({bits, -1});
    }
    return it->second;
  }
  int root_of(int flood) const {
    while (floods_[static_cast<std::size_t>(flood)].root != flood)
      flood = floods_[static_cast<std::size_t>(flood)].root;
    return flood;
  }
  void take(int flood, const glm::ivec3& key, std::size_t index) {
    Part& part = parts_at(key)[index];
    part.flood = flood;
    Flood& f = floods_[static_cast<std::size_t>(flood)];
    f.edge.emplace_back(key, index);
    f.taken.emplace_back(key, index);
    f.samples += count(part.bits);
  }
  int join(int a, int b) {
    Flood* to = &floods_[static_cast<std::size_t>(a)];
    Flood* from = &floods_[static_cast<std::size_t>(b)];
    if (to->taken.size() < from->taken.size()) std::swap(to, from), std::swap(a, b);
    to->edge.insert(to->edge.end(), from->edge.begin(), from->edge.end());
    to->taken.insert(to->taken.end(), from->taken.begin(), from->taken.end());
    to->samples += from->samples;
    from->root = a;
    from->edge = {};
    from->taken = {};
    return a;
  }
  void spread(int flood) {
    flood = root_of(flood);
    if (floods_[static_cast<std::size_t>(flood)].edge.empty()) return;
    const auto [key, index] = floods_[static_cast<std::size_t>(flood)].edge.front();
    floods_[static_cast<std::size_t>(flood)].edge.pop_front();
    const SolidBits bits = parts_at(key)[index].bits;
    for (int face = 0; face < 6; ++face) {
      const SolidBits touched = across(bits, face);
      if (!any(touched)) continue;
      const glm::ivec3 next = neighbour(key, face);
      std::vector<Part>& parts = parts_at(next);
      for (std::size_t i = 0; i < parts.size(); ++i) {
        if (!overlap(parts[i].bits, touched)) continue;
        if (parts[i].flood < 0) {
          take(flood, next, i);
        } else if (const int other = root_of(parts[i].flood); other != flood) {
          flood = join(flood, other);
        }
      }
    }
  }

  LoosePieces& pieces_;
  const TissueVolume& volume_;
  Blocks<std::vector<Part>> parts_;
  std::vector<Flood> floods_;
};

LoosePieces::LoosePieces(const TissueVolume& volume) {
  glm::ivec3 lo, hi;
  volume.bounds(lo, hi);
  if (lo.x > hi.x) return;
  Floods floods(*this, volume);
  for (int x = floor_div(lo.x, kEdge); x <= floor_div(hi.x, kEdge); ++x) {
    for (int y = floor_div(lo.y, kEdge); y <= floor_div(hi.y, kEdge); ++y) {
      for (int z = floor_div(lo.z, kEdge); z <= floor_div(hi.z, kEdge); ++z) {
        const SolidBits& bits = solid(volume, {x, y, z});
        if (any(bits)) floods.start({x, y, z}, bits);
      }
    }
  }
  floods.run();
  std::vector<TissuePiece> bodies = floods.pieces();
  body_count_ = bodies.size();
  if (!bodies.empty()) bodies.pop_back();
  int number = 0;
  for (const TissuePiece& body : bodies) {
    ++number;
    for (const BlockPart& part : body) bodies_[part.key].push_back({part.bits, number});
  }
}

const SolidBits& LoosePieces::solid(const TissueVolume& volume, const glm::ivec3& key) {
  const auto [it, fresh] = solid_.try_emplace(key);
  if (fresh) volume.solid_block(key, it->second);
  return it->second;
}

/// Compares a block with what was seen of it last.
void LoosePieces::note_emptied(const TissueVolume& volume, const glm::ivec3& key) {
  SolidBits now;
  volume.solid_block(key, now);
  const auto [known, unseen] = solid_.try_emplace(key, now);
  SolidBits gone;
  // Of a block that was not seen since the last edit all that is air now may have been tissue.
  for (std::size_t i = 0; i < 8; ++i) gone[i] = unseen ? ~now[i] : known->second[i] & ~now[i];
  known->second = now;
  if (!any(gone)) return;
  SolidBits& emptied = emptied_[key];
  for (std::size_t i = 0; i < 8; ++i) emptied[i] |= gone[i];
}

std::vector<TissuePiece> LoosePieces::after_cut(const TissueVolume& volume, const VoxelBox& written,
                                                std::span<const glm::ivec3> blocks) {
  const glm::ivec3 lo = block_of(written.lo), hi = block_of(written.hi);
  if (!(glm::all(glm::greaterThanEqual(lo, all_seen_lo_)) && glm::all(glm::lessThanEqual(hi, all_seen_hi_)))) {
    for (int x = lo.x; x <= hi.x; ++x) {
      for (int y = lo.y; y <= hi.y; ++y) {
        for (int z = lo.z; z <= hi.z; ++z) {
          if (!solid_.contains({x, y, z})) note_emptied(volume, {x, y, z});
        }
      }
    }
    all_seen_lo_ = lo, all_seen_hi_ = hi;
  }
  for (const glm::ivec3& key : blocks) note_emptied(volume, key);
  credit_ = std::min(credit_ + kCreditPerCut, kMostCredit);
  if (emptied_.empty() || credit_ <= 0) return {};

  std::vector<glm::ivec3> keys;  // in an order of their own: maps have none
  for (const auto& [key, bits] : emptied_) keys.push_back(key);
  std::sort(keys.begin(), keys.end(), before);
  Floods floods(*this, volume);
  for (const glm::ivec3& key : keys) {
    const SolidBits& gone = emptied_[key];
    floods.start(key, grown(gone));
    for (int face = 0; face < 6; ++face) {
      const SolidBits beside = across(gone, face);
      if (any(beside)) floods.start(neighbour(key, face), beside);
    }
  }
  emptied_.clear();
  floods.run();
  credit_ -= floods.looked_at();
  const std::vector<TissuePiece> found = floods.pieces();
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
  for (int x = floor_div(lo.x, kEdge); x <= floor_div(hi.x, kEdge); ++x) {
    for (int y = floor_div(lo.y, kEdge); y <= floor_div(hi.y, kEdge); ++y) {
      for (int z = floor_div(lo.z, kEdge); z <= floor_div(hi.z, kEdge); ++z) {
        volume.solid_block({x, y, z}, solid_[{x, y, z}]);
      }
    }
  }
}

void LoosePieces::after_edit() {
  solid_.clear();
  all_seen_lo_ = glm::ivec3(0), all_seen_hi_ = glm::ivec3(-1);
  emptied_.clear();
}

void LoosePieces::removed(std::span<const TissuePiece> pieces) {
  for (const TissuePiece& piece : pieces) {
    for (const BlockPart& part : piece) {
      SolidBits& bits = solid_[part.key];
      for (std::size_t i = 0; i < 8; ++i) bits[i] &= ~part.bits[i];
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
