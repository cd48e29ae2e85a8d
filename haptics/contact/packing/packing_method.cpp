#include "haptics/contact/packing/packing_method.h"

#include <fmt/format.h>

#include <charconv>
#include <utility>
#include <vector>

#include "engine/base/cached_result.h"
#include "engine/base/error.h"
#include "engine/base/keys.h"
#include "engine/base/units.h"
#include "haptics/contact/packing/packing_body.h"
#include "haptics/contact/packing/packing_model.h"
#include "haptics/packing.h"

namespace typodont::haptics {

namespace {

PackingLoader& loader() {
  static PackingLoader load;
  return load;
}

ToolMeshReader& tool_mesh_reader() {
  static ToolMeshReader read;
  return read;
}

}  // namespace

ToolMeshReaderRegistration::ToolMeshReaderRegistration(ToolMeshReader read) {
  tool_mesh_reader() = std::move(read);
}

PackingLoaderRegistration::PackingLoaderRegistration(PackingLoader load) {
  loader() = std::move(load);
}

namespace packing {

namespace {

constexpr cache::Shelf kPackings{"packing", ".packing", 256u << 20, kNanosPerSecond / 2};

bool parts_of(cache::Parts& file, SpherePacking& p) {
  return file.value(p.seed) && file.value(p.tissue_hash) && file.value(p.max_radius) && file.value(p.max_hole) &&
         file.value(p.solid_volume) && file.values(p.center) && file.values(p.radius) && file.values(p.tissue);
}

/// Result of pack_spheres(), read from the cache on disk if it is stored there, because a packing takes seconds to
/// compute. Equal input gives bit-identical spheres.
SpherePacking cached_packing(const TissueVolume& tissue, const PackOptions& options) {
  Sha256 key;
  cache::add_build(key);
  key.add(tissue.hash());
  key.add(static_cast<std::uint64_t>(options.spheres));
  key.add(options.seed);
  key.add(options.max_radius);
  SpherePacking packing;
  cache::read_or_make(
      kPackings, key.key(), [&](cache::Parts& file) { return parts_of(file, packing); },
      [&] { packing = pack_spheres(tissue, options); });
  return packing;
}

class PackingMethod final : public ContactMethod {
 public:
  explicit PackingMethod(Parameters parameters, std::optional<SpherePacking> packing)
      : parameters_(std::move(parameters)), packing_(std::move(packing)) {}
  std::string_view name() const override { return kName; }
  std::unique_ptr<ContactModel> make_model(const ServoSettings& settings) const override {
    return std::make_unique<PackingModel>(settings, parameters_);
  }
  std::unique_ptr<TissueBody> make_body(TissueVolume tissue, std::span<const Tool> tools) const override {
    const SpherePacking packing = packing_of(tissue);
    if (parameters_.material_hash && *parameters_.material_hash != packing.tissue_hash) {
      throw Error(parameters_.material.string(), "tissue_hash", fmt::format("{:016x}", *parameters_.material_hash),
                  fmt::format("{:016x}, the tissue of this scene", packing.tissue_hash));
    }
    return std::make_unique<PackingBody>(std::move(tissue), packing, tools, parameters_);
  }
  SpherePacking packing_of(const TissueVolume& tissue) const {
    if (packing_) return *packing_;
    PackOptions options;
    options.spheres = parameters_.spheres;
    options.seed = parameters_.seed;
    return cached_packing(tissue, options);
  }
  const Parameters& parameters() const { return parameters_; }

 private:
  Parameters parameters_;
  std::optional<SpherePacking> packing_;  // packing from a file; empty: it is computed
};

/// The parameter for the hardness of each sphere, from a file that `fit-material` wrote.
void describe_material(Keys& keys, Parameters& p) {
  if (const auto spheres = keys(must("spheres"), kNumber, "number of spheres");
      spheres && static_cast<std::size_t>(spheres->integer(1)) != p.spheres)
    spheres->fail(fmt::format("{}, as many as the scene's packing has", p.spheres));
  if (const auto seed = keys(must("seed"), kNumber, "seed of the packing");
      seed && static_cast<std::uint64_t>(seed->integer(0)) != p.seed)
    seed->fail(fmt::format("{}, the seed of the scene's packing", p.seed));
  if (const auto json = keys(must("tissue_hash"), kText, "hash of the fitted tissue")) {
    const std::string hash = json->string();
    std::uint64_t value = 0;
    const auto [end, error] = std::from_chars(hash.data(), hash.data() + hash.size(), value, 16);
    if (error != std::errc() || end != hash.data() + hash.size()) json->fail("a number in hexadecimal");
    p.material_hash = value;
  }
  keys.ignore("mean_square_error_N2");
  const auto sphere = keys(must("sphere"), kNumbers, "numbers of the fitted spheres");
  const auto hardness = keys(must("hardness"), kNumbers, "their hardness");
  if (!keys.json()) return;
  const std::vector<Json> spheres = sphere->items(), values = hardness->items();
  if (spheres.size() != values.size()) hardness->fail(fmt::format("{} numbers", spheres.size()));
  p.fitted.assign(p.spheres, 1.0f);
  for (std::size_t k = 0; k < spheres.size(); ++k) {
    const long long i = spheres[k].integer(0, static_cast<long long>(p.spheres) - 1);
    p.fitted[static_cast<std::size_t>(i)] = static_cast<float>(values[k].number(0, 1e4));
  }
}

}  // namespace

std::optional<Packed> packed_by(const SharedContactMethod& method, const TissueVolume& tissue) {
  const auto* const packing = dynamic_cast<const PackingMethod*>(method.get());
  if (!packing) return std::nullopt;
  return Packed{packing->packing_of(tissue), packing->parameters()};
}

SharedContactMethod read(Keys& keys) {
  Parameters p;
  std::optional<SpherePacking> packing;
  keys("spheres", p.spheres, {1, PackOptions::kMaxSpheres}, "spheres in the tissue; at most 64 in a voxel");
  keys("seed", p.seed, {0}, "seed of the packing");
  if (const auto file = keys("file", kFile,
                             "the output of `typodont pack` for this tissue, instead of `spheres` and `seed`. It is an "
                             "error to state `spheres` too")) {
    if (keys.json()->has("spheres")) keys.json()->fail("spheres and file", "one of both");
    if (!loader()) file->fail("a program that cannot read packings", "a program that can");
    p.file = file->file().parent_path() / file->string();
    packing = loader()(p.file);
    p.spheres = packing->size(), p.seed = packing->seed;
  }
  keys("tool_spheres", p.tool_spheres, {1, 2000}, "number of spheres of a head that is not a ball");
  keys("speed_mm_per_s", p.base_speed, {1e-3, 1e3, kMillimetre},
       "a constant cutting speed at density 1, as in the paper; it does not depend on the push. Default: the power of "
       "the motor determines the speed, as with `offset`");
  const auto density = [&](Keys& of) {
    for (std::size_t i = 1; i < kTissueCount; ++i)
      of(name_of(static_cast<Tissue>(i)).data(), p.density[i], {0, 1000}, "");
  };
  keys("density", density,
       "for example `{\"enamel\":1.5, \"dentin\":1, \"pulp\":0}`, each 0–1000: density relative to dentin. Default: "
       "the ratio of the specific cutting energies");
  keys("density_by_contact", p.by_contact, "the density grows with the contact area; only with `speed_mm_per_s`");
  if (keys.json() && keys.json()->has("density_by_contact") && !(p.base_speed > 0))
    (*keys.json())["density_by_contact"].fail("density_by_contact without speed_mm_per_s", "both");
  bool as_printed = false;
  keys("as_printed", as_printed, "true: the published formula computes the removed volume");
  p.removal = as_printed ? Removal::kAsPrinted : Removal::kMended;
  if (const auto material = keys("material", kFile, "the output of `fit-material` for this packing")) {
    p.material = material->file().parent_path() / material->string();
    read_keys(Json::load(p.material), [&](Keys& of) { describe_material(of, p); });
  }
  std::string mesh_file;
  double unit = kMillimetre;
  const auto mesh = [&](Keys& of) {
    of(must("file"), mesh_file,
       "the mesh, with coordinates in the tool's frame (origin at the head's centre, shank along +z)");
    of("unit_mm", unit, {1e-6, 1e6, kMillimetre}, "length of one unit of the file");
    if (of.json() && !tool_mesh_reader()) of.json()->fail("a program that cannot read meshes", "a program that can");
  };
  keys("tool_mesh", mesh,
       "a closed mesh as the head of the first tool, packed with `tool_spheres` spheres. The picture shows the tool "
       "that the scene names");
  if (keys.json() && keys.json()->has("tool_mesh"))
    p.tool_mesh =
        tool_spheres(*tool_mesh_reader()(keys.json()->file().parent_path() / mesh_file, unit), p.tool_spheres, p.seed);
  return std::make_shared<PackingMethod>(std::move(p), std::move(packing));
}

}  // namespace packing

std::vector<ShownSphere> shown_spheres(const Carver& carver, const ServoSettings& settings) {
  const auto* const body = dynamic_cast<const packing::PackingBody*>(&carver.body());
  const auto* const method = dynamic_cast<const packing::PackingMethod*>(settings.method.get());
  if (!body || !method) return {};
  const PerTissue density = packing::densities(method->parameters(), settings.materials);
  const packing::SphereTissue& spheres = body->spheres();
  std::vector<ShownSphere> shown;
  for (int i = 0; i < static_cast<int>(spheres.size()); ++i) {
    const double r = spheres.tree().radius(i);
    if (!(r > 0)) continue;
    shown.push_back(
        {spheres.tree().center(i), r, density[static_cast<std::size_t>(spheres.tissue(i))] * spheres.hardness(i)});
  }
  return shown;
}

}  // namespace typodont::haptics
