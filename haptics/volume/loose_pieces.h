// What a cut leaves without hold: pieces of tissue that no longer hang together with the body they were part of.
#pragma once

#include <array>
#include <cstdint>
#include <glm/glm.hpp>
#include <memory>
#include <span>
#include <unordered_map>
#include <vector>

#include "haptics/dense_tissue.h"

namespace typodont::haptics {

class TissueVolume;

/// Which of a block's 8³ samples lie in tissue: bit 8 y + z of word x.
using SolidBits = std::array<std::uint64_t, 8>;

/// Part of a piece: samples of one block; `key` counts blocks, its first sample is 8 key.
struct BlockPart {
  glm::ivec3 key{0};
  SolidBits bits{};
};
using TissuePiece = std::vector<BlockPart>;

/// Watches a volume as it is cut. Samples hang together over their six faces. A cut can only part what lies around the
/// samples that it turned to air, so from each of the parts that meet there one flood spreads, all at the same pace,
/// until they have met: mostly within the same block. A flood that ends alone has gone round a loose piece. What it
/// costs goes with that piece, not with the tooth.
///
/// What was apart before anything was cut (two teeth) stays: only of what was one body the smaller part is loose.
/// Deterministic: equal volumes and equal cuts, equal pieces.
class LoosePieces {
 public:
  /// Looks through the whole volume once, for its bodies.
  explicit LoosePieces(const TissueVolume& volume);
  ~LoosePieces();

  /// After a cut that wrote within `written` and may have emptied samples of `blocks` (TissueVolume::Carved): the
  /// pieces that it set loose, which are still in the volume.
  std::vector<TissuePiece> after_cut(const TissueVolume& volume, const VoxelBox& written,
                                     std::span<const glm::ivec3> blocks);
  /// After samples lo .. hi were written to otherwise.
  void after_fill(const TissueVolume& volume, const glm::ivec3& lo, const glm::ivec3& hi);
  /// After strokes were taken back or brought again: everything may have changed.
  void after_edit();
  /// How many there were at the start.
  std::size_t bodies() const { return body_count_; }
  /// These were taken out of the volume.
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
  class SeenBlocks;

  bool same_body(const TissuePiece& a, const TissuePiece& b) const;
  std::vector<int> bodies_of(const TissuePiece& piece) const;
  void note_emptied(const TissueVolume& volume, const glm::ivec3& key);

  std::unique_ptr<SeenBlocks> blocks_;           // as last seen
  glm::ivec3 all_seen_lo_{0}, all_seen_hi_{-1};  // a box of blocks, inclusive, that are all among them
  std::size_t body_count_ = 0;
  std::unordered_map<glm::ivec3, std::vector<Body>, KeyHash> bodies_;  // of all but the largest, which is number 0
  std::vector<BlockPart> emptied_;  // samples that turned to air and were not looked around yet; keys may repeat
  std::int64_t credit_ = 0;         // blocks that may still be looked at: a cut brings some, a flood takes them
};

}  // namespace typodont::haptics
