// Finds loose pieces: tissue that a cut separated from its body.
#pragma once

#include <array>
#include <cstdint>
#include <glm/glm.hpp>
#include <memory>
#include <span>
#include <unordered_map>
#include <vector>

#include "engine/contract/contact.h"
#include "haptics/dense_tissue.h"

namespace typodont::haptics {

class TissueVolume;

/// One bit for each of a block's 8³ samples, set if the sample is in tissue: bit 8 y + z of word x.
using SolidBits = std::array<std::uint64_t, 8>;

/// Some samples of one block, for example the part of a loose piece in it; the block's first sample is at 8·key.
struct BlockPart {
  glm::ivec3 key{0};
  SolidBits bits{};
};
using TissuePiece = std::vector<BlockPart>;

/// Finds the tissue that a cut separates from its body. Samples are connected through their six faces. A cut can only
/// separate tissue around the samples that became air. So a flood fill starts in each part of the tissue around these
/// samples. All floods spread at the same rate until they have met, mostly within one block. A flood that ends without
/// meeting another flood has filled a loose piece. So the cost depends on the size of the piece, and not on the size of
/// the tooth.
/// Bodies that were separate before the first cut (two teeth) are not loose pieces. If a cut divides a body, only the
/// smaller part is a loose piece. Deterministic: equal volumes and equal cuts give equal pieces.
class LoosePieces {
 public:
  /// Searches the whole volume once for its bodies.
  explicit LoosePieces(const TissueVolume& volume);
  ~LoosePieces();

  /// Returns the pieces that a cut separated; the volume still contains them. `written`: box of the voxels that the
  /// cut wrote. `blocks`: the blocks in which tissue may have become air; their bits mark the samples still in tissue.
  std::vector<TissuePiece> after_cut(const TissueVolume& volume, const VoxelBox& written,
                                     std::span<const BlockPart> blocks);
  /// Must be called if something other than a cut has changed the samples lo .. hi.
  void after_fill(const TissueVolume& volume, const glm::ivec3& lo, const glm::ivec3& hi);
  /// Must be called after an undo or redo, because any sample may have changed.
  void after_edit();
  /// Returns the number of bodies (separate parts of the tissue) at the start.
  std::size_t bodies() const { return body_count_; }
  /// Must be called after `pieces` were removed from the volume.
  void removed(std::span<const TissuePiece> pieces);

 private:
  struct KeyHash {
    std::size_t operator()(const glm::ivec3& k) const {
      return static_cast<std::size_t>(k.x) * 73856093u ^ static_cast<std::size_t>(k.y) * 19349663u ^
             static_cast<std::size_t>(k.z) * 83492791u;
    }
  };
  struct Body {
    SolidBits bits{};
    int number = 0;
  };
  struct Emptied {
    BlockPart part;
    int block = 0;  // index of the part's block in blocks_
  };
  class KnownBlocks;

  bool same_body(const TissuePiece& a, const TissuePiece& b) const;
  std::vector<int> bodies_of(const TissuePiece& piece) const;
  void note_emptied(int block, const SolidBits& now, bool unseen);

  std::unique_ptr<KnownBlocks> blocks_;          // the solid samples of the blocks as they were last read
  glm::ivec3 all_seen_lo_{0}, all_seen_hi_{-1};  // box of blocks, inclusive; blocks_ contains all of them
  std::size_t body_count_ = 0;
  // samples of all bodies, except the largest body, which has number 0 and is not stored
  std::unordered_map<glm::ivec3, std::vector<Body>, KeyHash> bodies_;
  // samples that became air but whose surroundings were not searched yet; a key may occur several times
  std::vector<Emptied> emptied_;
  // number of blocks that may still be visited: each cut adds to it, and each flood fill subtracts from it
  std::int64_t credit_ = 0;
};

}  // namespace typodont::haptics
