#include "haptics/contact/packing/packing_method.h"

#include <fmt/format.h>

#include <charconv>
#include <utility>
#include <vector>

#include "engine/base/error.h"
#include "engine/base/units.h"
#include "haptics/contact/packing/cached_packing.h"
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

/// Reads the hardness of each sphere from a `fit-material` file.
void read_material(const Json& json, Parameters& p) {
  json.allow_only({"spheres", "seed", "tissue_hash", "mean_square_error_N2", "sphere", "hardness"});
  if (static_cast<std::size_t>(json["spheres"].integer(1)) != p.spheres) {
    json["spheres"].fail(fmt::format("{}, as many as the scene's packing has", p.spheres));
  }
  if (static_cast<std::uint64_t>(json["seed"].integer(0)) != p.seed) {
    json["seed"].fail(fmt::format("{}, the seed of the scene's packing", p.seed));
  }
  const std::string hash = json["tissue_hash"].string();
  std::uint64_t value = 0;
  const auto [end, error] = std::from_chars(hash.data(), hash.data() + hash.size(), value, 16);
  if (error != std::errc() || end != hash.data() + hash.size()) json["tissue_hash"].fail("a number in hexadecimal");
  p.material_hash = value;
  const std::vector<Json> sphere = json["sphere"].items(), hardness = json["hardness"].items();
  if (sphere.size() != hardness.size()) json["hardness"].fail(fmt::format("{} numbers", sphere.size()));
  p.fitted.assign(p.spheres, 1.0f);
  for (std::size_t k = 0; k < sphere.size(); ++k) {
    const long long i = sphere[k].integer(0, static_cast<long long>(p.spheres) - 1);
    p.fitted[static_cast<std::size_t>(i)] = static_cast<float>(hardness[k].number(0, 1e4));
  }
}

}  // namespace

const Parameters* parameters_of(const SharedContactMethod& method) {
  const auto* const packing = dynamic_cast<const PackingMethod*>(method.get());
  return packing ? &packing->parameters() : nullptr;
}

std::optional<Packed> packed_by(const SharedContactMethod& method, const TissueVolume& tissue) {
  const auto* const packing = dynamic_cast<const PackingMethod*>(method.get());
  if (!packing) return std::nullopt;
  return Packed{packing->packing_of(tissue), packing->parameters()};
}

SharedContactMethod read(const std::optional<Json>& json) {
  Parameters p;
  std::optional<SpherePacking> packing;
  if (json) {
    json->allow_only({"spheres", "seed", "file", "tool_spheres", "speed_mm_per_s", "density", "density_by_contact",
                      "as_printed", "material", "tool_mesh"});
    constexpr auto kMost = static_cast<long long>(PackOptions::kMaxSpheres);
    if (const auto n = json->find("spheres")) p.spheres = static_cast<std::size_t>(n->integer(1, kMost));
    if (const auto n = json->find("seed")) p.seed = static_cast<std::uint64_t>(n->integer(0));
    if (const auto n = json->find("tool_spheres")) p.tool_spheres = static_cast<std::size_t>(n->integer(1, 2000));
    if (const auto speed = json->find("speed_mm_per_s")) p.base_speed = speed->number(1e-3, 1e3) * kMillimetre;
    if (const auto by_contact = json->find("density_by_contact")) {
      if (!(p.base_speed > 0)) by_contact->fail("density_by_contact without speed_mm_per_s", "both");
      p.by_contact = by_contact->boolean();
    }
    p.removal = json->boolean_or("as_printed", false) ? Removal::kAsPrinted : Removal::kMended;
    if (const auto densities = json->find("density")) {
      for (const std::string& name : densities->keys()) {
        const auto tissue = tissue_named(name);
        if (!tissue || *tissue == Tissue::kAir) densities->fail('"' + name + '"', "names of tissues");
        p.density[static_cast<std::size_t>(*tissue)] = (*densities)[name].number(0, 1000);
      }
    }
    if (const auto file = json->find("file")) {
      if (json->has("spheres")) json->fail("spheres and file", "one of both");
      if (!loader()) file->fail("a program that cannot read packings", "a program that can");
      p.file = json->file().parent_path() / file->string();
      packing = loader()(p.file);
      p.spheres = packing->size(), p.seed = packing->seed;
    }
    if (const auto mesh = json->find("tool_mesh")) {
      mesh->allow_only({"file", "unit_mm"});
      if (!tool_mesh_reader()) mesh->fail("a program that cannot read meshes", "a program that can");
      const auto solid = tool_mesh_reader()(json->file().parent_path() / (*mesh)["file"].string(),
                                            mesh->number_or("unit_mm", 1, 1e-6, 1e6) * kMillimetre);
      p.tool_mesh = tool_spheres(*solid, p.tool_spheres, p.seed);
    }
    if (const auto material = json->find("material")) {
      p.material = json->file().parent_path() / material->string();
      read_material(Json::load(p.material), p);
    }
  }
  return std::make_shared<PackingMethod>(std::move(p), std::move(packing));
}

}  // namespace packing

}  // namespace typodont::haptics
