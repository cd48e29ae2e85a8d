// Imports a scan or a closed mesh as tissue: a distance field and labels. Called at set-up; throws Error.
// README.md of this folder has an overview and defines the terms.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "engine/base/pose.h"
#include "haptics/dense_tissue.h"

namespace typodont::haptics {

enum class ImportPreset {
  kTooth,  // a tooth: enamel over dentin, and pulp in the cavities
  kArch,   // teeth and gingiva as a mesh from an intraoral scanner; the mesh is open below, and a base closes it
  kBone,   // a bone: cortical over cancellous bone; marrow spaces count as cancellous
  kJaw,    // a jaw as a scan: bone, teeth, pulp, nerve canals and metal
};

/// Grey values of a scan from which the hardness (hardness.h) is interpolated linearly. At the grey value `zero` and
/// below, the hardness is 0. In the softer tissue (dentin, cancellous bone), the hardness is 1 at the grey value `own`
/// and above. In the denser tissue (enamel, cortical bone), it is 1 at the grey value `dense` and above. If `dense` is
/// not given, the denser tissue has hardness 1 everywhere. Pulp always has hardness 1.
struct HardnessGreys {
  double zero = 0, own = 1;
  std::optional<double> dense;
};

/// A closed mesh of one tissue.
struct ImportPart {
  Tissue tissue;
  std::filesystem::path file;
};

/// A mesh file, and the pose of the file's frame F in the frame W of the result.
struct PlacedMesh {
  std::filesystem::path file;
  Pose X_WF;
};

/// A box in a scan, in m in the file's coordinates (as ImportReport::lo).
struct ImportRegion {
  dvec3 lo{0}, hi{0};
};

struct ImportOptions {
  ImportPreset preset = ImportPreset::kTooth;
  // closed meshes that are imported instead of one file; where they overlap, the tissue is that of the later one in
  // this list
  std::vector<ImportPart> parts;
  // m, voxel edge of the result; if not given, the scan's smallest spacing, or 0.1 mm for a mesh
  std::optional<double> voxel;
  // number of the DICOM series in the list that the program prints for a folder with several series
  std::optional<int> series;
  std::optional<dvec3> spacing;  // m, spacing along the scan's own axes; replaces the spacing that the file states
  // Grey value that separates the surroundings from the softer tissue. If not given, it is found from the histogram.
  std::optional<double> surface_grey;
  // Grey value that separates the softer tissue from the denser tissue. If not given, it is found from the histogram.
  std::optional<double> dense_grey;
  std::optional<double> hounsfield;  // grey value of 0 Hounsfield units; if not given, it is found from the histogram
  std::optional<double> nan_grey;    // grey value that replaces NaN in voxels; if not given, such voxels are an error
  glm::dmat3 turn{1};                // rotation by quarter turns (quarter_turns) that is applied to the result
  // Maps the scan's grey values to hardness. If not given, every tissue has its usual hardness everywhere.
  std::optional<HardnessGreys> hardness;
  double band = 1.5e-3;  // m; on both sides of the surface, the result has exact distances up to this value
  // The part of a scan that is imported. If not given, everything is imported. The grey values of the tissues are found
  // in the whole scan.
  std::optional<ImportRegion> region;
  double mesh_unit = 1e-3;      // length in m of one unit of a mesh file
  Pose mesh_pose;               // pose of a mesh file's frame in the frame of the result
  std::optional<double> shell;  // m, thickness of the dense outer tissue of a mesh (enamel or cortical bone)
  // m, height of a crown from the gingiva to the cusps; used for an arch whose mesh has no colours
  std::optional<double> crown;
  bool greys = true;             // if true, the scan's grey values are kept; write_preview() needs them
  std::optional<double> memory;  // bytes, largest memory that the import may use; if not given, the free memory
  /// Function that is called before the work begins, with the estimated memory in bytes. May be empty.
  std::function<void(double)> estimated;
  std::function<void(double)> progress;  // is called with the progress 0..1; may be empty
};

/// A nerve canal, which is found as a dark tube in the bone.
struct JawCanal {
  std::vector<dvec3> centre;  // m, points of the centre line in the file's coordinates
  // m, standard deviation of the position of the centre line, in the directions across the canal
  double uncertainty = 0;
};

/// A tooth of a jaw. Teeth that touch each other are separated at the narrowest place between them.
struct JawTooth {
  dvec3 centre{0};    // m, centre of the tooth's volume in the file's coordinates
  double volume = 0;  // m³, volume of the tooth including its pulp and metal
};

/// What was found in a jaw: teeth and canals, and how uncertain the borders and labels are.
struct JawReport {
  std::vector<JawTooth> teeth;  // the teeth with enamel or metal, the largest first
  double border = 0;            // m, standard deviation of the position of a border between two tissues
  // m³, expected volume whose label is wrong (tooth labelled as bone, or bone as tooth)
  double mislabelled = 0;
  std::vector<JawCanal> canals;

  /// Returns the number of teeth with enamel or metal.
  int crowns() const { return static_cast<int>(teeth.size()); }
};

/// Grey values with which corrections (corrections.h) decide between cortical and cancellous bone, and between enamel
/// and dentin.
struct KindGreys {
  double cortical = 0;  // lowest grey value of cortical bone
  double enamel = 0;    // lowest grey value of enamel
  // Grey values from which the hardness of bone is computed. The hardness is 0 at the grey value `soft`. It is 1 at
  // own_cancellous in cancellous bone, and 1 at own_cortical in cortical bone.
  double soft = 0, own_cancellous = 1, own_cortical = 1;
};

struct ImportReport {
  std::string format;              // name of the format: "NRRD", "STL" …
  dvec3 spacing{0};                // m, spacing of the scan; zero for a mesh
  double voxel = 0;                // m, voxel edge of the result
  glm::ivec3 size{0};              // size of the result in voxels
  dvec3 lo{0}, hi{0};              // m, bounding box of the surface in the file's coordinates
  double height = 0;               // m, longest edge of the bounding box
  PerTissue volume{};              // m³ of each tissue
  PerTissue volume_uncertainty{};  // m³, uncertainty of each tissue's volume; zero for a mesh
  PerTissue hardness{};  // mean hardness of each tissue, 0..1; valid only if hardness was derived from grey values
  int bodies_found = 0;  // number of connected bodies of tissue in the scan
  int bodies_kept = 0;   // number of connected bodies of tissue in the result
  int pulp_parts = 0;    // number of connected pieces of pulp
  std::optional<double> false_dentin;  // fraction of a tooth crown's outer surface that is labelled dentin
  // Grey values of a scan (0 for a mesh): that of the surroundings, that of the softer tissue, and the threshold
  // between these two grey values.
  double outside_grey = 0, soft_grey = 0, surface_grey = 0;
  std::optional<double> dense_level, dense_grey;
  KindGreys kinds;
  double noise_grey = 0;  // standard deviation of the grey values of the surroundings
  double blur = 0;        // m, standard deviation of the scan's blur, measured at edges
  double memory = 0;      // bytes, largest memory that the import needs; estimated before the import begins
  // Coordinate space of the file: "LPS" (x to the patient's left, y to the back, z to the head), "RAS" (x to the right,
  // y to the front, z to the head), or empty if unknown.
  std::string space;
  /// Rotation from the result to the file's space. A point p of the result (m) has the position world_rotation · p in
  /// that space.
  glm::dmat3 world_rotation{1};
  std::optional<JawReport> jaw;
  double overlap = 0;  // m³, volume that lies in more than one mesh of import_meshes()
  // Bounding boxes of the meshes of import_meshes() that do not meet the bounding box of the first mesh.
  std::vector<ImportRegion> others;
  std::vector<std::string> repairs;  // descriptions of the repairs of the mesh, for the user
  // m, points of a mesh at which it was repaired, in the coordinates of the result; the picture of the surface marks
  // them
  std::vector<dvec3> repaired;
  std::vector<std::string> notes;  // notes about the import for the user
};

struct Imported {
  DenseTissue tissue;
  ImportReport report;
  // Grey values of the scan at the voxels of `tissue`, for pictures. Empty for a mesh or if they were not requested.
  std::vector<float> grey;
};

/// Returns true if the file or folder is read as DICOM. The name of a DICOM file may contain a person's name.
bool is_dicom(const std::filesystem::path& file);

/// Returns the extensions of the supported files in lower case: ".nrrd", …
const std::vector<std::string>& scan_endings();
const std::vector<std::string>& mesh_endings();
/// Returns true if the name of the file has the extension of a mesh, in upper or lower case.
bool is_mesh_file(const std::filesystem::path& file);

/// Imports a scan (DICOM, NRRD, NIfTI, MetaImage) or a mesh (STL, PLY, OBJ, glTF). Positions are in m, in the
/// coordinates of the file. An oblique scan is rotated so that its axes become the axes of the volume
/// (ImportReport::world_rotation reverses this). If the options contain parts, `file` is not read.
Imported import_tissue(const std::filesystem::path& file, const ImportOptions& options);

/// Imports several meshes with the same preset and joins them in one volume. If a voxel lies in more than one mesh, it
/// gets the tissue of the mesh in which it lies deepest. ImportReport::overlap states the volume of the overlap. Throws
/// Error.
Imported import_meshes(const std::vector<PlacedMesh>& meshes, const ImportOptions& options);

/// Reads a list of rotations by quarter turns such as "x90,y-90,z180", which are applied in this order. They are
/// right-handed rotations about the axes. Throws Error.
glm::dmat3 quarter_turns(const std::string& text);
/// Rotates the tissue and its grey values about the origin by a matrix of quarter turns. Samples are only moved, not
/// interpolated.
void turn(Imported& imported, const glm::dmat3& by);

/// Writes pictures as PNG files to `folder`, which is created if missing. The axial, coronal and sagittal slices show
/// grey values and, beside them, tissue colours with the outline of the surface. A further picture shows the surface
/// from six sides. Returns the files.
std::vector<std::filesystem::path> write_preview(const Imported& imported, const std::filesystem::path& folder);

}  // namespace typodont::haptics
