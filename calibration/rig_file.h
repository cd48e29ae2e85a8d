// Reads and writes the calibrated fields of a rig file: screen, mirror, head, X_WH, and "calibration" (date, serial
// numbers, covariances, captures). Other fields do not change. Throws Error.
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
  /// load() reads a rig; create() makes a mirror bench.
  static RigFile load(const std::filesystem::path& file);
  static RigFile create(const std::filesystem::path& file);
  RigFile(RigFile&&) noexcept;
  ~RigFile();

  /// The bench of the file, with defaults for missing parts.
  BenchState bench() const;
  /// Folder of the captures that the file states, or "FILE.captures" beside it.
  std::filesystem::path captures_folder() const;

  /// Date of a step's result, "2026-03-01T10:15:00Z"; empty: never solved.
  std::string step_date(const std::string& step) const;

  /// Stores the results of a bench. Steps without a result keep their stored record. Throws Error for implausible eyes
  /// or an implausible panel.
  void set(const BenchState& bench);
  /// Stores the current date for a step that computes no result, such as the drift check.
  void mark_done(const std::string& step);
  void set_device(const std::string& role, const std::string& serial);
  /// Writes the file with the current date, completely or not at all.
  void save();

 private:
  struct Document;
  explicit RigFile(std::unique_ptr<Document> document);
  std::unique_ptr<Document> document_;
};

/// The calibration as JSON, for --json and "calibration.steps" of a rig.
std::string bench_json(const BenchState& bench);

}  // namespace typodont::calibration
