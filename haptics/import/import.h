// From a scan or a closed mesh to tissue: greys in, distance field and labels out. Set-up time; throws Error.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "haptics/dense_tissue.h"

namespace typodont::haptics {

enum class ImportPreset {
  kTooth,  // enamel over dentin, pulp in its cavities
  kArch,   // a mesh of teeth and gum, as an intraoral scanner gives it: open below, closed with a base
  kBone,   // cortical over cancellous bone; marrow spaces count as cancellous
  kJaw,    // a scan: bone, teeth, pulp, nerve canals and metal
};

/// A linear map from a scan's greys to hardness (hardness.h): 0 at `zero` and below, 1 at the tissue's own grey and
/// above. That of the softer tissue is `own`, that of the denser one `dense`, which keeps hardness 1 where that is not
/// given. Pulp keeps hardness 1.
struct HardnessGreys {
  double zero = 0, own = 1;
  std::optional<double> dense;
};

/// A closed mesh that is one tissue.
struct ImportPart {
  Tissue tissue;
  std::filesystem::path file;
};

struct ImportOptions {
  ImportPreset preset = ImportPreset::kTooth;
  std::vector<ImportPart> parts;          // instead of one file; where they overlap the later one counts
  std::optional<double> voxel;            // m; the smallest source spacing when not given (of a mesh: 0.1 mm)
  std::optional<int> series;              // of several in a folder of DICOM files, as the list of them numbers them
  std::optional<dvec3> spacing;           // m, along the scan's own axes, instead of the file's
  std::optional<double> surface_grey;     // between the surround and the softer tissue, instead of the histogram's
  std::optional<double> dense_grey;       // between the softer tissue and the denser
  std::optional<double> hounsfield;       // the greys are Hounsfield units plus this; none: found in the histogram
  std::optional<double> nan_grey;         // stands for voxels that are no number; none: they are an error
  glm::dmat3 turn{1};                     // a rotation by quarter turns (quarter_turns), applied to the result
  std::optional<HardnessGreys> hardness;  // from the scan's greys; none: every tissue has its own
  double band = 1.5e-3;                   // m, distances are true as far as this from the surface
  double mesh_unit = 1e-3;                // m per unit of a mesh file
  std::optional<double> shell;            // m, a mesh: thickness of the dense outer tissue
  std::optional<double> crown;            // m, an arch without colours: how far below its cusps a crown ends
  bool greys = true;                      // also keep a scan's greys beside the tissue, as write_preview() needs them
  std::optional<double> memory;           // bytes at most; none: what is free
  /// Called once the work is known, before it begins: bytes that it takes at most, about.
  std::function<void(double)> estimated;
  std::function<void(double)> progress;  // 0..1, may be empty
};

/// A dark tube in the bone.
struct JawCanal {
  std::vector<dvec3> centre;  // m, in the file's coordinates
  double doubt = 0;           // m, standard deviation of a centre across the canal, from their scatter
};

/// What a jaw's labels are worth.
struct JawReport {
  int crowns = 0;            // pieces of enamel and metal; neighbours that touch are one
  double border = 0;         // m, standard deviation of a border between tissues
  PerTissue volume_doubt{};  // m³, of each tissue
  double unsure = 0;         // m³ of what is tooth or bone, expected to be taken for the other
  std::vector<JawCanal> canals;
};

struct ImportReport {
  std::string format;                  // "NRRD", "STL" …
  dvec3 spacing{0};                    // m, of the scan (zero for a mesh)
  double voxel = 0;                    // m, of the result
  glm::ivec3 size{0};                  // voxels of the result
  dvec3 lo{0}, hi{0};                  // m, bounds of the surface in the file's coordinates
  double height = 0;                   // m, the longest of the bounds
  PerTissue volume{};                  // m³
  PerTissue hardness{};                // mean of each, 0..1; where the scan's greys were asked for it
  int bodies_found = 0;                // connected pieces of tissue in the scan
  int bodies_kept = 0;                 // in the result
  int pulp_parts = 0;                  // connected pieces of pulp
  std::optional<double> false_dentin;  // tooth: share of the crown's outer surface that is labelled dentin
  // Scans only: greys.
  double outside_grey = 0, soft_grey = 0, surface_grey = 0;
  std::optional<double> dense_level, dense_grey;
  double noise_grey = 0;  // standard deviation in the surround
  double blur = 0;        // m, standard deviation of the edge response
  /// The file's space and how the result lies in it: a place p of the result, in m, is world_rotation · p there.
  double memory = 0;  // bytes at most, as estimated before the work
  std::string space;  // "LPS": x to the patient's left, y to the back, z to the head; "RAS"; empty: not known
  glm::dmat3 world_rotation{1};
  std::optional<JawReport> jaw;
  std::vector<std::string> repairs;  // of a mesh, in plain words
  std::vector<std::string> notes;    // what a user should know, in plain words
};

struct Imported {
  DenseTissue tissue;
  ImportReport report;
  std::vector<float> grey;  // the scan's greys at the same voxels, for pictures; empty for a mesh or where not wanted
};

/// Whether the file or folder is read as DICOM: then its name, too, may be a person's.
bool is_dicom(const std::filesystem::path& file);

/// Endings of the files that can be read, lower case: ".nrrd", …
const std::vector<std::string>& scan_endings();
const std::vector<std::string>& mesh_endings();

/// Reads scans (DICOM, NRRD, NIfTI, MetaImage) and meshes (STL, PLY, OBJ, glTF). Positions are the file's own (its
/// first voxel at its own origin), in metres; those of an oblique scan are turned so that its axes are the volume's
/// (ImportReport::world_rotation turns them back). `file` is not read where the options name parts.
Imported import_tissue(const std::filesystem::path& file, const ImportOptions& options);

/// "x90", "y-90", "z180" or several with commas between, done one after the other: right-handed turns about the axes.
/// Throws Error.
glm::dmat3 quarter_turns(const std::string& text);
/// The tissue, and the greys beside it, turned about the origin by a matrix of quarter turns: no sample is made up.
void turn(Imported& imported, const glm::dmat3& by);

/// Axial, coronal and sagittal slices as PNG files in `folder` (made when missing): greys beside tissue colours with
/// the surface drawn in, and the surface from six sides. Returns the files.
std::vector<std::filesystem::path> write_preview(const Imported& imported, const std::filesystem::path& folder);

}  // namespace typodont::haptics
