// Reads and writes the calibrated fields of a rig file: screen, mirror, head, X_WH (the pose of the haptic base in
// frame W), and the block "calibration" with date, device serials, covariances and the folder of the raw captures. Does
// not change any other field. Throws Error with the file and the key.
#pragma once

#include <array>
#include <filesystem>
#include <map>
#include <memory>
#include <string>

#include "calibration/routine.h"

namespace typodont::calibration {

class RigFile {
 public:
  /// Loads an existing rig file. If there is none, creates the rig of a mirror bench.
  static RigFile load(const std::filesystem::path& file);
  static RigFile create(const std::filesystem::path& file);
  RigFile(RigFile&&) noexcept;
  ~RigFile();

  /// Returns geometry and arm from the file. Parts that are missing in the file have their default values.
  BenchState bench() const;
  /// Returns the folder that the file names, or "FILE.captures" beside the rig.
  std::filesystem::path captures_folder() const;

  /// Returns the date at which a calibration step was last solved, for example "2026-03-01T10:15:00Z"; empty if it was
  /// never solved.
  std::string step_date(const std::string& step) const;

  /// Copies the results of the bench's calibration steps into the file. Steps without a result keep their old record.
  void set(const BenchState& bench);
  /// Stores the present time as the date of a calibration step that computes no result.
  void mark_done(const std::string& step);
  void set_device(const std::string& role, const std::string& serial);
  /// Stores the present time as the calibration's date, and writes the file completely or not at all.
  void save();

 private:
  struct Document;
  explicit RigFile(std::unique_ptr<Document> document);
  std::unique_ptr<Document> document_;
};

/// Returns the results of all calibration steps as JSON, for the option --json and for "calibration.steps" of the rig.
std::string bench_json(const BenchState& bench);

}  // namespace typodont::calibration
