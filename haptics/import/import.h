// A scan or closed mesh as tissue. Set-up; throws Error (README.md).
#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "engine/base/pose.h"
#include "haptics/dense_tissue.h"

namespace typodont::haptics {

enum class ImportPreset {
  kTooth,  // a tooth: enamel over dentin, and pulp in the cavities
  kArch,   // intraoral mesh, open below, closed by a base
  kBone,   // cortical over cancellous bone
  kJaw,    // a scan: bone, teeth, pulp, nerve canals, metal
};

/// Hardness, linear in the grey value: 0 at `zero`; 1 at `own` in the softer tissue, at `dense` (or everywhere) in the
/// denser one; pulp 1.
struct HardnessGreys {
  double zero = 0, own = 1;
  std::optional<double> dense;
};

/// A closed mesh of one tissue.
struct ImportPart {
  Tissue tissue;
  std::filesystem::path file;
};

/// File, and pose of its frame F in the result's W.
struct PlacedMesh {
  std::filesystem::path file;
  Pose X_WF;
};

/// m, file coordinates (as ImportReport::lo).
struct ImportRegion {
  dvec3 lo{0}, hi{0};
};

struct ImportOptions {
  ImportPreset preset = ImportPreset::kTooth;
  // closed meshes instead of a file; later ones win
  std::vector<ImportPart> parts;
  // m; empty: the scan's smallest, or 0.1 mm
  std::optional<double> voxel;
  // of the DICOM series in the printed list
  std::optional<int> series;
  std::optional<dvec3> spacing;  // m along the scan's axes, instead of the file's
  // between surroundings and softer tissue; empty: from the histogram
  std::optional<double> surface_grey;
  // between softer and denser tissue; empty: from the histogram
  std::optional<double> dense_grey;
  std::optional<double> hounsfield;  // of 0 Hounsfield units; empty: from the histogram
  std::optional<double> nan_grey;    // for NaN voxels; empty: an error
  glm::dmat3 turn{1};                // quarter_turns() of the result
  // empty: usual hardness everywhere
  std::optional<HardnessGreys> hardness;
  // Tissues of a label map's values, before those that the file names; not empty: the scan is a label map.
  std::map<int, Tissue> labels;
  double band = 1.5e-3;  // m, exact distances on both sides
  // empty: everything; grey values always come from the whole scan
  std::optional<ImportRegion> region;
  double mesh_unit = 1e-3;      // length in m of one unit of a mesh file
  Pose mesh_pose;               // file frame in the result
  std::optional<double> shell;  // m, of enamel or cortical bone
  // m, gingiva to cusps, for an arch without colours
  std::optional<double> crown;
  bool greys = true;             // keeps them, for write_preview()
  std::optional<double> memory;  // bytes; empty: the free memory
  /// with the estimated bytes, before the work; may be empty
  std::function<void(double)> estimated;
  std::function<void(double)> progress;  // is called with the progress 0..1; may be empty
};

/// A dark tube in the bone.
struct JawCanal {
  std::vector<dvec3> centre;  // m, points of the centre line in the file's coordinates
  // m, of the centre line, across the canal
  double uncertainty = 0;
};

/// Touching teeth are separated where they are narrowest.
struct JawTooth {
  dvec3 centre{0};    // m, centre of the tooth's volume in the file's coordinates
  double volume = 0;  // m³, volume of the tooth including its pulp and metal
};

struct JawReport {
  std::vector<JawTooth> teeth;  // the teeth with enamel or metal, the largest first
  double border = 0;            // m, position of a border
  // m³ expected between tooth and bone
  double mislabelled = 0;
  std::vector<JawCanal> canals;

  /// Returns the number of teeth with enamel or metal.
  int crowns() const { return static_cast<int>(teeth.size()); }
};

/// For corrections: cortical or cancellous, enamel or dentin.
struct KindGreys {
  double cortical = 0;  // lowest grey value of cortical bone
  double enamel = 0;    // lowest grey value of enamel
  // Of bone: 0 at `soft`, 1 at own_cancellous and own_cortical.
  double soft = 0, own_cancellous = 1, own_cortical = 1;
};

struct ImportReport {
  std::string format;                  // name of the format: "NRRD", "STL" …
  dvec3 spacing{0};                    // m, spacing of the scan; zero for a mesh
  double voxel = 0;                    // m, voxel edge of the result
  glm::ivec3 size{0};                  // size of the result in voxels
  dvec3 lo{0}, hi{0};                  // m, bounding box of the surface in the file's coordinates
  double height = 0;                   // m, longest edge of the bounding box
  PerTissue volume{};                  // m³ of each tissue
  PerTissue volume_uncertainty{};      // m³, uncertainty of each tissue's volume; zero for a mesh
  PerTissue hardness{};                // 0..1, if derived from grey values
  int bodies_found = 0;                // number of connected bodies of tissue in the scan
  int bodies_kept = 0;                 // number of connected bodies of tissue in the result
  int pulp_parts = 0;                  // number of connected pieces of pulp
  std::optional<double> false_dentin;  // of a crown's outer surface
  // 0 for a mesh
  double outside_grey = 0, soft_grey = 0, surface_grey = 0;
  std::optional<double> dense_level, dense_grey;
  KindGreys kinds;
  double noise_grey = 0;  // standard deviation of the grey values of the surroundings
  double blur = 0;        // m, standard deviation of the scan's blur, measured at edges
  double memory = 0;      // bytes, estimated before
  // "LPS" (left, back, head), "RAS" (right, front, head), or empty
  std::string space;
  /// p of the result (m) is at world_rotation · p
  glm::dmat3 world_rotation{1};
  std::optional<JawReport> jaw;
  double overlap = 0;  // m³ in several of import_meshes()
  // Boxes of import_meshes() apart from the first.
  std::vector<ImportRegion> others;
  std::vector<std::string> repairs;  // descriptions of the repairs of the mesh, for the user
  // m, of mesh repairs, in the result
  std::vector<dvec3> repaired;
  std::vector<std::string> notes;  // notes about the import for the user
};

struct Imported {
  DenseTissue tissue;
  ImportReport report;
  // Of the scan at `tissue`'s voxels; empty for a mesh, or if not asked.
  std::vector<float> grey;
};

/// Its name may contain a person's name.
bool is_dicom(const std::filesystem::path& file);

/// Lower case: ".nrrd", …
const std::vector<std::string>& scan_endings();
const std::vector<std::string>& mesh_endings();
/// By extension, in any case.
bool is_mesh_file(const std::filesystem::path& file);

/// m in the file's coordinates; an oblique scan keeps its own axes (ImportReport::world_rotation). With parts, `file`
/// is not read.
Imported import_tissue(const std::filesystem::path& file, const ImportOptions& options);

/// One volume; a shared voxel gets the tissue of the mesh in which it lies deepest (ImportReport::overlap). Throws
/// Error.
Imported import_meshes(const std::vector<PlacedMesh>& meshes, const ImportOptions& options);

/// "x90,y-90,z180" in this order, right-handed. Throws Error.
glm::dmat3 quarter_turns(const std::string& text);
/// About the origin; samples only move.
void turn(Imported& imported, const glm::dmat3& by);

/// Axial, coronal and sagittal slices with grey values and tissues, and the surface from six sides. Returns the files.
std::vector<std::filesystem::path> write_preview(const Imported& imported, const std::filesystem::path& folder);

}  // namespace typodont::haptics
