// A scan before its import: three sections, region, preview of labels, corrections with undo. Has no window and no
// thread: the caller computes requested labels. Main thread. Positions in m, in the file's frame F.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string_view>
#include <vector>

#include "engine/app/planning/implant_planner.h"
#include "engine/render/picture.h"
#include "haptics/import/corrections.h"
#include "haptics/import/scan_volume.h"

namespace typodont {

/// Number of sections of a scan: axial, coronal and sagittal.
inline constexpr std::size_t kScanSections = 3;
using ScanPlanes = std::array<SectionPlane, kScanSections>;

/// Detail of the computed labels: none, labels of only some voxels, labels of all voxels.
enum class LabelDetail { kNone, kCoarse, kFull };

/// A request for tissue labels, computed with ScanVolume::import().
struct LabelRequest {
  LabelDetail detail = LabelDetail::kNone;
  std::uint64_t revision = 0;  // version of region and preset for which labels are requested
  haptics::ImportOptions options;
};

class ScanReview {
 public:
  explicit ScanReview(std::shared_ptr<const haptics::ScanVolume> scan);

  const std::shared_ptr<const haptics::ScanVolume>& scan() const { return scan_; }

  // All sections pass through the crosshair.
  const dvec3& crosshair() const { return crosshair_; }
  /// Moves the crosshair to p_F, limited to the scan.
  void look_at(const dvec3& p_F);
  /// Moves the crosshair by `slices` voxels perpendicular to the section.
  void scroll(std::size_t section, int slices);
  /// Width of the sections, m, from 10 mm to the whole scan. A smaller width centres the sections at the crosshair.
  double width() const { return width_; }
  double whole_width() const { return whole_; }
  void set_width(double width);
  ScanPlanes planes() const;
  /// Letters for the patient's sides in the picture: R and L, or A and P. Empty if the orientation is unknown.
  std::array<std::string_view, 2> sides(std::size_t section) const;

  // The following functions read or change the region of the scan that will be imported.
  const haptics::ImportRegion& region() const { return region_; }
  /// Sets the region; it is limited to the scan, and at least 3 mm wide.
  void set_region(const haptics::ImportRegion& region);
  /// Faces of the region closer than `reach` (m) to p_F in this section. For each axis: −1 lower, +1 upper, 0 none.
  glm::ivec3 walls_at(std::size_t section, const dvec3& p_F, double reach) const;
  void move_walls(const glm::ivec3& walls, const dvec3& p_F);
  /// While the user drags a face of the region, requests only coarse labels.
  void set_dragging(bool dragging);

  // The following functions concern the tissue labels of the region.
  haptics::ImportPreset preset() const { return preset_; }
  void set_preset(haptics::ImportPreset preset);
  /// Requests labels for all voxels. When the user stops dragging, this happens automatically.
  void want_full() { full_wanted_ = true; }
  /// Next request: coarse before full labels. Empty: nothing is missing.
  std::optional<LabelRequest> request() const;
  /// Takes computed labels. Labels of an earlier region are used only if they are coarse and no full labels fit the
  /// region. Corrections are repeated on full labels.
  void take(const LabelRequest& request, haptics::Imported labels);
  /// Reports that a request failed. Coarse labels are then not requested again for this region, full labels only after
  /// want_full().
  void give_up(const LabelRequest& request);
  LabelDetail detail() const { return detail_; }
  /// True if the labels fit the current region and preset.
  bool current() const { return detail_ != LabelDetail::kNone && labels_revision_ == revision_; }
  /// The tissue labels; null if none are computed yet.
  const haptics::Imported* labels() const { return detail_ == LabelDetail::kNone ? nullptr : &labels_; }
  const PerTissue& volumes() const { return volumes_; }  // the volume (m³) of each tissue
  /// The options for importing the region with full tissue labels.
  haptics::ImportOptions options() const;

  // Corrections need full labels of the current region.
  bool can_correct() const { return current() && detail_ == LabelDetail::kFull; }
  /// Corrects the labels. `joins`: this correction belongs to the same stroke as the previous one, so both are undone
  /// together.
  void correct(const haptics::Correction& correction, bool joins = false);
  bool can_undo() const { return can_correct() && done_ > 0; }
  bool can_redo() const { return can_correct() && done_ < steps_.size(); }
  void undo();
  void redo();
  /// Replaces the tissue by one on the same grid, for example with the crowns of an intraoral scan. This can be undone,
  /// and is lost when labels are computed again.
  void replace(haptics::DenseTissue tissue);
  /// The corrections that are not undone, in order. Calls of replace() do not count as corrections.
  std::vector<haptics::Correction> corrections() const;

  /// Picture of a section: grey values with the labels' colours, darker outside of the region. `pixels`: side of the
  /// picture.
  render::Picture picture(const SectionPlane& plane, int pixels) const;
  /// Increases whenever picture() or planes() would give another result.
  std::uint64_t changes() const { return changes_; }

 private:
  struct Step {
    std::vector<haptics::Correction> corrections;
    std::vector<haptics::BoxContent> before;  // labels before the correction; after undo(): labels that redo() restores
  };

  void apply(Step& step, const haptics::Correction& correction);
  void exchange(haptics::BoxContent& content);

  std::shared_ptr<const haptics::ScanVolume> scan_;
  dvec3 crosshair_, centre_;
  double whole_ = 0, width_ = 0;  // m: width of the scan; width of the shown part
  haptics::ImportRegion region_;
  haptics::ImportPreset preset_ = haptics::ImportPreset::kTooth;
  bool dragging_ = false, full_wanted_ = false;
  std::uint64_t revision_ = 1;  // number that increases whenever the region or the preset changes
  LabelDetail detail_ = LabelDetail::kNone, given_up_ = LabelDetail::kNone;
  std::uint64_t labels_revision_ = 0;
  haptics::Imported labels_;
  PerTissue volumes_{};
  std::vector<Step> steps_;
  std::size_t done_ = 0;  // number of correction steps that were not undone
  std::uint64_t changes_ = 0;
};

/// Colour of a label, sRGB, 0 to 255.
glm::dvec3 label_color(Tissue tissue);

}  // namespace typodont
