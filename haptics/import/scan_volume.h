// A scan in memory, for regions.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "haptics/import/import.h"

namespace typodont::haptics {

/// Any thread after construction. m, file coordinates along the scan's axes (as ImportReport).
class ScanVolume {
 public:
  /// No mesh. Options: series, spacing, nan_grey, hounsfield. Throws Error.
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

  /// Trilinear; outside, the wall's.
  double grey(const dvec3& p) const;
  // 2 % are darker than black(), 0.3 % brighter than white().
  double black() const { return black_; }
  double white() const { return white_; }

  /// options.region, or all, as import_tissue(); larger options.voxel for a preview. Several threads at once. Throws
  /// Error, and from progress.
  Imported import(const ImportOptions& options) const;

 private:
  struct Content;
  std::unique_ptr<Content> content_;
  double black_ = 0, white_ = 1;
};

}  // namespace typodont::haptics
