// Import of a scan or a closed mesh as tissue: grey values become a distance field and labels. Set-up time; throws
// Error.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "haptics/dense_tissue.h"

namespace typodont::haptics {

enum class ImportPreset {
  kTooth,  // enamel over dentin, pulp in the cavities
  kArch,   // a mesh of teeth and gingiva from an intraoral scanner; it is open below, and a base closes it
  kBone,   // cortical over cancellous bone; marrow spaces count as cancellous
  kJaw,    // a scan: bone, teeth, pulp, nerve canals and metal
};

/// A linear map from a scan's grey values to hardness (hardness.h) for each of the scan's two hard tissues: hardness
/// 0 at the grey value `zero` and below; hardness 1 at `own` and above in the softer tissue (dentin, cancellous
/// bone), at `dense` and above in the denser one (enamel, cortical bone). If `dense` is not given, the denser tissue
/// has hardness 1. Pulp always has hardness 1.
struct HardnessGreys {
  double zero = 0, own = 1;
  std::optional<double> dense;
};

/// A closed mesh that consists of one tissue.
struct ImportPart {
  Tissue tissue;
  std::filesystem::path file;
};

/// A box in a scan, m, in the file's coordinates (those of ImportReport::lo).
struct ImportRegion {
  dvec3 lo{0}, hi{0};
};

struct ImportOptions {
  ImportPreset preset = ImportPreset::kTooth;
  std::vector<ImportPart> parts;  // parts instead of one file; where they overlap, the later part is used
  std::optional<double> voxel;    // m, voxel of the result; default: the scan's smallest spacing; for a mesh 0.1 mm
  std::optional<int> series;      // number of the DICOM series, if a folder contains several; as in the printed list
  std::optional<dvec3> spacing;   // m, spacing along the scan's own axes, instead of the spacing in the file
  // grey value, threshold between the surroundings and the softer tissue; default: from the histogram
  std::optional<double> surface_grey;
  // grey value of the threshold between the softer and the denser tissue; default: from the histogram
  std::optional<double> dense_grey;
  std::optional<double> hounsfield;  // grey value of 0 Hounsfield units; default: from the histogram
  std::optional<double> nan_grey;  // grey value for voxels that are not a number; without it, such voxels are an error
  glm::dmat3 turn{1};              // rotation by quarter turns (quarter_turns), applied to the result
  // Hardness from the scan's grey values; nullopt: every tissue has its own hardness
  std::optional<HardnessGreys> hardness;
  double band = 1.5e-3;  // m, largest distance on both sides of the surface for which true distances are computed
  // The part of a scan that is imported; default: all of it. The grey values of the tissues are found in the whole
  // scan.
  std::optional<ImportRegion> region;
  double mesh_unit = 1e-3;       // m per unit of a mesh file
  std::optional<double> shell;   // m, for a mesh: thickness of the dense outer tissue
  std::optional<double> crown;   // m, for an arch without colours: height of a crown below its cusps
  bool greys = true;             // true: the scan's grey values are kept, which write_preview() needs
  std::optional<double> memory;  // bytes, limit; default: the free memory
  /// Called before the work begins, with the estimated memory in bytes.
  std::function<void(double)> estimated;
  std::function<void(double)> progress;  // 0..1, may be empty
};

/// A nerve canal: a dark tube in the bone.
struct JawCanal {
  std::vector<dvec3> centre;  // m, points of the centre line in the file's coordinates
  double uncertainty = 0;     // m, standard deviation of the centres across the canal
};

/// Uncertainty of a jaw's labels.
struct JawReport {
  int crowns = 0;                  // number of pieces of enamel and metal; touching neighbours are one piece
  double border = 0;               // m, standard deviation of the position of a border between tissues
  PerTissue volume_uncertainty{};  // m³, uncertainty of each tissue's volume
  double mislabelled = 0;          // m³, expected volume of tooth labelled as bone, and of bone labelled as tooth
  std::vector<JawCanal> canals;
};

/// Grey values that decide between the two hard tissues of bone and of teeth, for corrections (corrections.h).
struct KindGreys {
  double cortical = 0;  // lower limit of cortical bone
  double enamel = 0;    // lower limit of enamel
  // Hardness of bone: 0 at `soft`, 1 at the tissue's own grey value
  double soft = 0, own_cancellous = 1, own_cortical = 1;
};

struct ImportReport {
  std::string format;                  // "NRRD", "STL" …
  dvec3 spacing{0};                    // m, spacing of the scan (zero for a mesh)
  double voxel = 0;                    // m, voxel of the result
  glm::ivec3 size{0};                  // size of the result in voxels
  dvec3 lo{0}, hi{0};                  // m, bounds of the surface in the file's coordinates
  double height = 0;                   // m, longest edge of the bounds
  PerTissue volume{};                  // m³
  PerTissue hardness{};                // mean hardness of each tissue, 0..1; only if it was derived from grey values
  int bodies_found = 0;                // connected pieces of tissue in the scan
  int bodies_kept = 0;                 // connected pieces of tissue in the result
  int pulp_parts = 0;                  // connected pieces of pulp
  std::optional<double> false_dentin;  // for a tooth: fraction of the crown's outer surface that is labelled dentin
  // Grey values, for scans only.
  double outside_grey = 0, soft_grey = 0, surface_grey = 0;
  std::optional<double> dense_level, dense_grey;
  KindGreys kinds;
  double noise_grey = 0;  // standard deviation of the surroundings' grey values
  double blur = 0;        // m, standard deviation of the edge response
  double memory = 0;      // bytes, largest memory need, estimated before the work
  // Coordinate space of the file: "LPS" (x to the patient's left, y to the back, z to the head), "RAS", or empty:
  // unknown
  std::string space;
  /// Rotation from the result to the file's space: a point p of the result, m, has the position world_rotation · p in
  /// that space.
  glm::dmat3 world_rotation{1};
  std::optional<JawReport> jaw;
  std::vector<std::string> repairs;  // repairs of the mesh, in plain words
  std::vector<std::string> notes;    // notes for the user, in plain words
};

struct Imported {
  DenseTissue tissue;
  ImportReport report;
  // The scan's grey values at the same voxels, for pictures; empty for a mesh or if not requested
  std::vector<float> grey;
};

/// Returns true if the file or folder is read as DICOM. Its name may then contain a person's name.
bool is_dicom(const std::filesystem::path& file);

/// Extensions of the supported files, lower case: ".nrrd", …
const std::vector<std::string>& scan_endings();
const std::vector<std::string>& mesh_endings();

/// Reads scans (DICOM, NRRD, NIfTI, MetaImage) and meshes (STL, PLY, OBJ, glTF). Positions are those of the file, in
/// metres. An oblique scan is rotated so that its axes become the volume's axes (ImportReport::world_rotation rotates
/// back). If the options name parts, `file` is not read.
Imported import_tissue(const std::filesystem::path& file, const ImportOptions& options);

/// Reads rotations such as "x90", "y-90" or "z180", or several separated by commas, applied in order. They are
/// right-handed rotations about the axes. Throws Error.
glm::dmat3 quarter_turns(const std::string& text);
/// Rotates the tissue and its grey values about the origin by a matrix of quarter turns; no sample is interpolated.
void turn(Imported& imported, const glm::dmat3& by);

/// Writes axial, coronal and sagittal slices as PNG files to `folder` (created if missing): grey values beside tissue
/// colours with the outline of the surface, and the surface from six sides. Returns the files.
std::vector<std::filesystem::path> write_preview(const Imported& imported, const std::filesystem::path& folder);

}  // namespace typodont::haptics
