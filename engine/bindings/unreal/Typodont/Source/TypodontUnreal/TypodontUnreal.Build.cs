// The module's name is not "Typodont": Unreal would define TYPODONT_API for it, which typodont.h already defines.
using System;
using System.IO;
using UnrealBuildTool;

public class TypodontUnreal : ModuleRules {
  public TypodontUnreal(ReadOnlyTargetRules Target) : base(Target) {
    PCHUsage = PCHUsageMode.UseExplicitOrSharedPCHs;
    PublicDependencyModuleNames.AddRange(new[] {"Core", "CoreUObject", "Engine"});
    PrivateDependencyModuleNames.Add("ProceduralMeshComponent");

    // An installation of the C interface: ./run library DIR
    string Prefix = Environment.GetEnvironmentVariable("TYPODONT_PREFIX") ?? "/usr/local";
    string Library = null;
    foreach (string Folder in new[] {"lib", "lib64", "lib/x86_64-linux-gnu"}) {
      string File = Path.Combine(Prefix, Folder, "libtypodont.so");
      if (Library == null && System.IO.File.Exists(File)) Library = File;
    }
    if (Library == null)
      throw new BuildException("no libtypodont.so below " + Prefix + ": set TYPODONT_PREFIX to its installation");
    PrivateIncludePaths.Add(Path.Combine(Prefix, "include"));
    PublicAdditionalLibraries.Add(Library);
    PublicRuntimeLibraryPaths.Add(Path.GetDirectoryName(Library));
  }
}
