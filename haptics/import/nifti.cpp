#include <fmt/format.h>
#include <nifti2_io.h>

#include <cmath>
#include <map>
#include <memory>

#include "engine/base/error.h"
#include "engine/base/late_library.h"
#include "engine/contract/tissue.h"
#include "haptics/import/scan.h"
#include "haptics/import/volume_export.h"

namespace typodont::haptics::importing {

namespace {
constinit LateLibrary nifti2{TYPODONT_LATE_NIFTI2}, znz{TYPODONT_LATE_ZNZ};
TYPODONT_LATE(nifti2, nifti_datatype_string, nifti_image_free, nifti_image_read, nifti_is_gzfile, nifti_set_debug_level,
              nifti_short_order)
TYPODONT_LATE(znz, Xznzclose, znzopen, znzread, znzseek)

struct FreeImage {
  void operator()(nifti_image* n) const { nifti_image_free(n); }
};
struct CloseStream {
  void operator()(znzFile f) const { znzclose(f); }
};
}  // namespace

static const std::map<int, Element> kElements = {{DT_INT8, Element::kInt8},     {DT_UINT8, Element::kUint8},
                                                 {DT_INT16, Element::kInt16},   {DT_UINT16, Element::kUint16},
                                                 {DT_INT32, Element::kInt32},   {DT_UINT32, Element::kUint32},
                                                 {DT_INT64, Element::kInt64},   {DT_UINT64, Element::kUint64},
                                                 {DT_FLOAT32, Element::kFloat}, {DT_FLOAT64, Element::kDouble}};

static RawScan read_nifti(const ScanRequest& request) {
  const std::filesystem::path& file = request.file;
  nifti_set_debug_level(0);  // this program has its own messages
  const std::unique_ptr<nifti_image, FreeImage> image(nifti_image_read(file.c_str(), 0));
  if (!image) throw Error(file.string(), "header", "no NIfTI header", "a NIfTI-1 or NIfTI-2 file");
  std::vector<long long> sizes;
  for (int a = 1; a <= std::clamp<int>(static_cast<int>(image->ndim), 0, 7); ++a) {
    if (a > 3 && image->dim[a] == 1) continue;
    sizes.push_back(image->dim[a]);
  }
  check_sizes(file, "header field \"dim\"", sizes, request.memory);
  const auto known = kElements.find(image->datatype);
  if (known == kElements.end()) {
    throw Error(file.string(), "header field \"datatype\"",
                fmt::format("{} ({})", image->datatype, nifti_datatype_string(image->datatype)),
                "a scalar number: 8 to 64 bit integers, float or double");
  }
  const Element element = known->second;
  const auto count =
      static_cast<std::size_t>(sizes[0]) * static_cast<std::size_t>(sizes[1]) * static_cast<std::size_t>(sizes[2]);
  const std::size_t bytes = count * bytes_of(element);

  if (!image->iname) throw Error(file.string(), "data", "no data file", "a .img beside the .hdr");
  const std::filesystem::path data = image->iname;
  const bool compressed = nifti_is_gzfile(image->iname) != 0;
  const auto offset = static_cast<long long>(image->iname_offset);
  const std::uintmax_t present = size_of_file(data);
  if (offset < 0 || offset > 1 << 30) {
    throw Error(file.string(), "header field \"vox_offset\"", fmt::format("{}", offset), "where the voxels begin");
  }
  const double least =
      compressed ? static_cast<double>(bytes) / 1032 : static_cast<double>(bytes) + static_cast<double>(offset);
  if (static_cast<double>(present) < least) {
    throw Error(data.string(), "data", fmt::format("{} bytes", present),
                fmt::format("at least {:.0f} bytes", std::ceil(least)));
  }
  znzFile opened = znzopen(data.c_str(), "rb", compressed ? 1 : 0);
  if (znz_isnull(opened)) throw Error(data.string(), "data", "an unreadable file", "the scan's voxels");
  const std::unique_ptr<std::remove_pointer_t<znzFile>, CloseStream> stream(opened);
  std::vector<char> raw(bytes);
  const bool sought = znzseek(opened, static_cast<znz_off_t>(offset), SEEK_SET) >= 0;
  const std::size_t got = sought ? znzread(raw.data(), 1, bytes, opened) : 0;
  if (got != bytes)
    throw Error(data.string(), "data", fmt::format("{} bytes of voxels", got), fmt::format("{}", bytes));

  RawScan scan;
  scan.format = "NIfTI";
  if (image->sform_code > 0 || image->qform_code > 0) scan.space = "RAS";
  scan.size = {static_cast<int>(sizes[0]), static_cast<int>(sizes[1]), static_cast<int>(sizes[2])};
  scan.grey = decode(raw, count, element, bytes_of(element) > 1 && image->byteorder != nifti_short_order());
  if (image->scl_slope != 0 && std::isfinite(image->scl_slope) && std::isfinite(image->scl_inter)) {
    for (float& g : scan.grey) g = static_cast<float>(image->scl_slope * static_cast<double>(g) + image->scl_inter);
  }

  if (image->intent_code == NIFTI_INTENT_LABEL) {
    scan.labels.emplace();
    if (std::string_view(image->intent_name) == kTissueLabels) {
      for (int t = 1; t < kTissueCount; ++t) (*scan.labels)[t] = name_of(static_cast<Tissue>(t));
    }
  }

  double unit = 1;
  scan.spacing_place = "header field \"pixdim\"";
  scan.has_unit = image->xyz_units != NIFTI_UNITS_UNKNOWN;
  if (image->xyz_units == NIFTI_UNITS_METER) unit = 1e3;
  if (image->xyz_units == NIFTI_UNITS_MICRON) unit = 1e-3;
  const double length[3] = {std::abs(image->dx), std::abs(image->dy), std::abs(image->dz)};
  scan.has_spacing = true;
  for (std::size_t k = 0; k < 3; ++k) {
    glm::dvec3& step = scan.step[k];
    step = glm::dvec3(0);
    step[static_cast<int>(k)] = length[k];
    if (image->sform_code > 0 || image->qform_code > 0) {
      const nifti_dmat44& m = image->sform_code > 0 ? image->sto_xyz : image->qto_xyz;
      for (int w = 0; w < 3; ++w) {
        step[w] = m.m[w][k];
        scan.origin[w] = m.m[w][3] * unit;
      }
    }
    step *= unit;
  }
  replace_impossible_steps(scan);
  return scan;
}

extern const ScanFormat nifti_format;
const ScanFormat nifti_format{"NIfTI", {".nii", ".nii.gz", ".hdr"}, {".img", ".img.gz"}, nullptr, read_nifti};

}  // namespace typodont::haptics::importing
