// A scan in memory, for the import of regions.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "haptics/import/import.h"

namespace typodont::haptics {

/// After construction, any thread. Positions in m, in file coordinates along the scan's axes (as ImportReport).
class ScanVolume {
 public:
  /// Reads a scan, not a mesh. Uses the options series, spacing, nan_grey and hounsfield. Throws Error.
  ScanVolume(const std::filesystem::path& file, const ImportOptions& options);
  ~ScanVolume();
  ScanVolume(const ScanVolume&) = delete;
  ScanVolume& operator=(const ScanVolume&) = delete;

  dvec3 lo() const;  // returns the centre of the first voxel, m
  dvec3 hi() const;  // returns the centre of the last voxel, m
  dvec3 spacing() const;
  const std::string& format() const;
  const std::string& space() const;  // coordinate space of the file: "LPS", "RAS" or empty (unknown)
  const std::vector<std::string>& notes() const;

  /// Trilinear interpolation; outside the scan, the value at its wall.
  double grey(const dvec3& p) const;
  // 2 % of the voxels are darker than black(), 0.3 % are brighter than white().
  double black() const { return black_; }
  double white() const { return white_; }

  /// Imports options.region or the whole scan, as import_tissue() does; a larger options.voxel gives a preview. Several
  /// threads may call import() at once. Throws Error, and what options.progress throws.
  Imported import(const ImportOptions& options) const;

 private:
  struct Content;
  std::unique_ptr<Content> content_;
  double black_ = 0, white_ = 1;
};

}  // namespace typodont::haptics
