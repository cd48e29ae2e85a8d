// Imports a scan or a closed mesh as tissue (README.md). For set-up; throws Error.
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
  kArch,   // intraoral mesh, open at the bottom, which a base closes
  kBone,   // cortical bone around cancellous bone
  kJaw,    // a scan: bone, teeth, pulp, nerve canals, metal
};

/// Grey values that define hardness, which is linear in the grey value: 0 at `zero`; 1 at `own` in the softer tissue,
/// and at `dense` in the denser tissue. Without `dense`, the denser tissue has hardness 1 everywhere, like pulp.
struct HardnessGreys {
  double zero = 0, own = 1;
  std::optional<double> dense;
};

/// A closed mesh that contains one tissue.
struct ImportPart {
  Tissue tissue;
  std::filesystem::path file;
};

/// A mesh file, and the pose of its frame F in the frame W of the imported volume.
struct PlacedMesh {
  std::filesystem::path file;
  Pose X_WF;
};

/// Box in the coordinates of the imported file, m.
struct ImportRegion {
  dvec3 lo{0}, hi{0};
};

struct ImportOptions {
  ImportPreset preset = ImportPreset::kTooth;
  // Closed meshes that replace the file; where they overlap, the later one counts.
  std::vector<ImportPart> parts;
  // Voxel edge of the imported volume, m; empty: the smallest spacing of the scan, or 0.1 mm for a mesh.
  std::optional<double> voxel;
  // Number of the DICOM series in the printed list.
  std::optional<int> series;
  std::optional<dvec3> spacing;  // m, spacing along the scan's axes that replaces the file's
  // Grey value that separates the surroundings from the softer tissue; empty: found in the histogram.
  std::optional<double> surface_grey;
  // Grey value that separates softer from denser tissue; empty: found in the histogram.
  std::optional<double> dense_grey;
  std::optional<double> hounsfield;  // grey value of 0 Hounsfield units; empty: automatic
  std::optional<double> nan_grey;    // grey value replacing NaN voxels; empty: NaN is an error
  glm::dmat3 turn{1};                // rotation of the imported volume, from quarter_turns()
  // If empty, all tissue has its usual hardness.
  std::optional<HardnessGreys> hardness;
  // Tissue of each value of a label map; overrides the tissues that the file names. If not empty, the scan is a label
  // map.
  std::map<int, Tissue> labels;
  double band = 1.5e-3;  // m, distances from the surface are exact up to this, on both sides
  // Part of the scan to import; empty: all. The grey values always come from the whole scan.
  std::optional<ImportRegion> region;
  double mesh_unit = 1e-3;      // length in m of one unit of a mesh file
  Pose mesh_pose;               // pose of the file's frame in the frame of the imported volume
  std::optional<double> shell;  // m, thickness of enamel or cortical bone in a mesh
  // Height of the crowns from gingiva to cusps, m, for an arch without colours.
  std::optional<double> crown;
  bool greys = true;             // true: the grey values are kept, for write_preview()
  std::optional<double> memory;  // bytes, largest allowed memory; empty: the free memory
  /// Receives the estimated memory in bytes before the work begins; may be empty.
  std::function<void(double)> estimated;
  std::function<void(double)> progress;  // is called with the progress 0..1; may be empty
};

/// A nerve canal: a dark tube in the bone.
struct JawCanal {
  std::vector<dvec3> centre;  // m, points of the centre line in the file's coordinates
  // Uncertainty of the centre line across the canal, m.
  double uncertainty = 0;
};

/// A tooth of a jaw. Touching teeth are separated where their contact is narrowest.
struct JawTooth {
  dvec3 centre{0};    // m, centre of the tooth's volume in the file's coordinates
  double volume = 0;  // m³, volume of the tooth including its pulp and metal
};

struct JawReport {
  std::vector<JawTooth> teeth;  // teeth with enamel or metal, the largest first
  double border = 0;            // m, uncertainty of the position of a border between tissues
  // Volume expected to be mislabelled between tooth and bone, m³.
  double mislabelled = 0;
  std::vector<JawCanal> canals;

  /// Returns the number of teeth with enamel or metal.
  int crowns() const { return static_cast<int>(teeth.size()); }
};

/// Grey values that distinguish the kinds of a tissue in corrections: cortical or cancellous bone, enamel or dentin.
struct KindGreys {
  double cortical = 0;  // lowest grey value of cortical bone
  double enamel = 0;    // lowest grey value of enamel
  // Grey values that define hardness: 0 at `soft`, 1 at own_cancellous or own_cortical.
  double soft = 0, own_cancellous = 1, own_cortical = 1;
};

struct ImportReport {
  std::string format;                  // name of the format: "NRRD", "STL" …
  dvec3 spacing{0};                    // m, spacing of the scan; zero for a mesh
  double voxel = 0;                    // m, voxel edge of the imported volume
  glm::ivec3 size{0};                  // size of the imported volume in voxels
  dvec3 lo{0}, hi{0};                  // m, bounding box of the tissue in the file's coordinates
  double height = 0;                   // m, longest edge of the bounding box
  PerTissue volume{};                  // m³ of each tissue
  PerTissue volume_uncertainty{};      // m³, uncertainty of each tissue's volume; zero for a mesh
  PerTissue hardness{};                // mean hardness of each tissue, 0..1, if grey values define it
  int bodies_found = 0;                // number of connected bodies of tissue in the scan
  int bodies_kept = 0;                 // number of connected bodies in the imported volume
  int pulp_parts = 0;                  // number of connected pieces of pulp
  std::optional<double> false_dentin;  // fraction of dentin on the crown's outer surface, which should be enamel
  // Grey values of the surroundings, the softer tissue and the surface; 0 for a mesh.
  double outside_grey = 0, soft_grey = 0, surface_grey = 0;
  std::optional<double> dense_level, dense_grey;
  KindGreys kinds;
  double noise_grey = 0;  // standard deviation of the grey values of the surroundings
  double blur = 0;        // m, standard deviation of the scan's blur, measured at edges
  double memory = 0;      // bytes, memory estimated before the work
  // Coordinate space of the file: "LPS" (left, back, head), "RAS" (right, front, head), or empty.
  std::string space;
  /// Position p (m) of the imported volume lies at world_rotation · p in the file's space.
  glm::dmat3 world_rotation{1};
  std::optional<JawReport> jaw;
  double overlap = 0;  // m³, volume that lies in more than one mesh of import_meshes()
  // Bounding boxes of the meshes of import_meshes(), except the first.
  std::vector<ImportRegion> others;
  std::vector<std::string> repairs;  // descriptions of the repairs of the mesh, for the user
  // Positions of mesh repairs in the imported volume, m.
  std::vector<dvec3> repaired;
  std::vector<std::string> notes;  // notes about the import for the user
};

struct Imported {
  DenseTissue tissue;
  ImportReport report;
  // Grey values of the scan at the voxels of `tissue`; empty for a mesh, or if not requested.
  std::vector<float> grey;
};

/// Returns true for DICOM files, whose names may contain a person's name.
bool is_dicom(const std::filesystem::path& file);

/// File extensions in lower case: ".nrrd", …
const std::vector<std::string>& scan_endings();
const std::vector<std::string>& mesh_endings();
/// Decides by the file extension, in upper or lower case.
bool is_mesh_file(const std::filesystem::path& file);

/// Positions are in m, in the file's coordinates. The tissue of an oblique scan keeps the scan's axes
/// (ImportReport::world_rotation). If `options` has parts, `file` is not read.
Imported import_tissue(const std::filesystem::path& file, const ImportOptions& options);

/// Imports several meshes into one volume. A voxel in several meshes gets the tissue of the mesh in which it lies
/// deepest (ImportReport::overlap). Throws Error.
Imported import_meshes(const std::vector<PlacedMesh>& meshes, const ImportOptions& options);

/// Rotation of a text such as "x90,y-90,z180": right-handed turns in this order. Throws Error.
glm::dmat3 quarter_turns(const std::string& text);
/// Rotates the imported volume about the origin by quarter turns; samples are moved, not interpolated.
void turn(Imported& imported, const glm::dmat3& by);

/// Writes pictures: axial, coronal and sagittal slices with grey values and tissues, and the surface from six sides.
/// Returns the files.
std::vector<std::filesystem::path> write_preview(const Imported& imported, const std::filesystem::path& folder);

}  // namespace typodont::haptics
