// All tissue, for contact models with a TissuePatch. Only for the carver, the thread that repeats the servo's cuts.
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "haptics/contact/proxy/non_cutting_contacts.h"
#include "haptics/contact/tissue_body.h"
#include "haptics/contact/tissue_patch.h"

namespace typodont::haptics::offset {

/// Keeps the tissue in an OpenVDB volume. A cut removes exactly the sweep of the head.
class FieldBody : public TissueBody {
 public:
  /// `intermediate`: true if the servo's model has an intermediate surface (intermediate_surface.h).
  FieldBody(TissueVolume tissue, std::span<const Tool> tools, bool intermediate = false);

  void carve(const Cut& cut, bool continues) override;
  void fill(const Cut& cut) override;
  std::vector<LoosePiece> take_pieces() override { return std::exchange(pieces_, {}); }
  void begin_stroke() override { volume_.begin_stroke(); }
  void end_stroke() override { volume_.end_stroke(); }
  bool undo() override;
  bool redo() override;
  PerTissue taken_back() const override { return volume_.taken_back(); }
  std::unique_ptr<Snapshot> make_snapshot() const override;
  double travel() const override { return travel_; }
  bool leads() const override { return true; }
  void cut_out(Snapshot& snapshot, std::uint32_t held) override;
  void remember_writes(bool) override {}  // nothing to start or stop: the volume always records its changes
  void bring_up_to_date(Snapshot& snapshot) override;
  TissueVolume& rasterize() override { return volume_; }
  std::uint64_t elements() const override;

 protected:
  const Tool& tool(const Cut& cut) const { return tools_[cut.tool]; }
  void take_out_pieces(const Cut& cut, const TissueVolume::Carved& carved);
  /// Adapts the search for loose pieces after filling was added in the box `filled`.
  void after_fill(const VoxelBox& filled) {
    if (!filled.empty()) loose_pieces_.after_fill(volume_, filled.lo, filled.hi);
  }

 private:
  template <class CopyPart, class CopyWritten>
  void renew(TissuePatch& patch, const glm::ivec3& lo, CopyPart copy_part, CopyWritten copy_written);
  bool copy_step(TissuePatch& patch, const glm::ivec3& lo, std::uint32_t held);
  void cut_out_complete(TissuePatch& patch, const glm::ivec3& lo);
  glm::ivec3 first_voxel(const dvec3& center_W, int n) const;
  void choose_grid();
  void mark_cut_boxes(TissuePatch& patch) const;
  TissuePatch sized_patch() const;

  TissueVolume volume_;
  std::vector<Tool> tools_;
  LoosePieces loose_pieces_;        // search for pieces that are cut off from the tissue
  std::vector<LoosePiece> pieces_;  // pieces that cuts separated and take_pieces() has not returned yet
  // The tissue patch copied last: its number, its first voxel, and TissueVolume::foreign_changes() at that time.
  struct {
    std::uint32_t number = 0;
    glm::ivec3 lo{0};
    std::uint64_t foreign_changes = 0;
  } last_;
  bool intermediate_;  // true: a complete tissue patch has a second copy of its samples, for an intermediate surface
  double travel_ = 0;  // m, distance that a head may move before it needs a new tissue patch
  int edge_ = 0;       // number of samples of a tissue patch along each axis
  // First voxel of a tissue patch that contains all tissue. nullopt: patches follow the tool.
  std::optional<glm::ivec3> whole_;
  // Sample spacing and size of the coarse tissue patch around the shank; 0: no tool has a shank.
  CoarseGrid coarse_;
};

}  // namespace typodont::haptics::offset
