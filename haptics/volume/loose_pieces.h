// Tissue that a cut separated from its body.
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

/// Bit 8 y + z of word x, per sample of 8³.
using SolidBits = std::array<std::uint64_t, 8>;

/// First sample at 8·key.
struct BlockPart {
  glm::ivec3 key{0};
  SolidBits bits{};
};
using TissuePiece = std::vector<BlockPart>;

/// Connected over six faces. A cut separates only around samples that it emptied: a flood starts in each part there,
/// all spread alike until they meet, mostly in one block; one that ends alone filled a loose piece. So cost follows the
/// piece, not the tooth. Bodies separate before the first cut are none; of a divided body the smaller part is.
/// Deterministic.
class LoosePieces {
 public:
  /// Searches the whole volume once for its bodies.
  explicit LoosePieces(const TissueVolume& volume);
  ~LoosePieces();

  /// Still in the volume. `written`: voxels; `blocks`: possibly emptied, bits still in tissue.
  std::vector<TissuePiece> after_cut(const TissueVolume& volume, const VoxelBox& written,
                                     std::span<const BlockPart> blocks);
  /// Something other than a cut changed lo .. hi.
  void after_fill(const TissueVolume& volume, const glm::ivec3& lo, const glm::ivec3& hi);
  /// After undo or redo: anything may have changed.
  void after_edit();
  /// At the start.
  std::size_t bodies() const { return body_count_; }
  /// After `pieces` left the volume.
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

  std::unique_ptr<KnownBlocks> blocks_;          // as last read
  glm::ivec3 all_seen_lo_{0}, all_seen_hi_{-1};  // blocks inclusive, all in blocks_
  std::size_t body_count_ = 0;
  // but the largest, number 0
  std::unordered_map<glm::ivec3, std::vector<Body>, KeyHash> bodies_;
  // not searched around yet; keys may repeat
  std::vector<Emptied> emptied_;
  // blocks: cuts add, floods subtract
  std::int64_t credit_ = 0;
};

}  // namespace typodont::haptics
