// Finds tissue that a cut has separated from its body.
#pragma once

#include <array>
#include <cstdint>
#include <glm/glm.hpp>
#include <memory>
#include <span>
#include <unordered_map>
#include <vector>

#include "engine/base/voxels.h"
#include "engine/contract/contact.h"
#include "haptics/dense_tissue.h"
#include "haptics/volume/leaf_key.h"

namespace typodont::haptics {

class TissueVolume;

/// One bit per sample of a block of 8³: bit 8 y + z of word x.
using SolidBits = std::array<std::uint64_t, 8>;

/// Some samples of a block of 8³; the block's first sample is at voxel 8·key.
struct BlockPart {
  glm::ivec3 key{0};
  SolidBits bits{};
};
using TissuePiece = std::vector<BlockPart>;

/// Tissue is connected over the six faces of voxels. After a cut, flood fills start around the emptied samples and grow
/// equally fast until they meet. A flood fill that ends without meeting others has filled a loose piece. Deterministic.
class LoosePieces {
 public:
  /// Searches the whole volume once for its bodies.
  explicit LoosePieces(const TissueVolume& volume);
  ~LoosePieces();

  /// Returns the pieces that a cut has separated; they are still in the volume. `written`: changed voxels; `blocks`:
  /// blocks that the cut may have emptied, each with a bit mask of its voxels that still contain tissue.
  std::vector<TissuePiece> after_cut(const TissueVolume& volume, const VoxelBox& written,
                                     std::span<const BlockPart> blocks);
  /// Updates the stored blocks after a change in the box lo..hi (voxels) that is not a cut.
  void after_fill(const TissueVolume& volume, const glm::ivec3& lo, const glm::ivec3& hi);
  /// Discards the stored blocks. Call it after undo or redo, which may change anything.
  void after_edit();
  /// Number of connected bodies of tissue at the start.
  std::size_t bodies() const { return body_count_; }
  /// Removes `pieces` from the stored blocks. Call it after `pieces` were removed from the volume.
  void removed(std::span<const TissuePiece> pieces);

 private:
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

  std::unique_ptr<KnownBlocks> blocks_;          // blocks as they were when last read
  glm::ivec3 all_seen_lo_{0}, all_seen_hi_{-1};  // box (inclusive) whose blocks are all in blocks_
  std::size_t body_count_ = 0;
  // for each block: the parts of all bodies in it, except of the largest body, which has the number 0
  std::unordered_map<glm::ivec3, std::vector<Body>, KeyHash> bodies_;
  // emptied samples where no search was made yet; a block may occur several times
  std::vector<Emptied> emptied_;
  // number of blocks that may be visited: cuts add to it, searches subtract from it
  std::int64_t credit_ = 0;
};

}  // namespace typodont::haptics
