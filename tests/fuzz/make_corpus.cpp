// Valid scenes for fuzz_scene to start from: make_corpus FOLDER.
#include <cstdio>

#include "scene/archive.h"
#include "transport_scenes.h"

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "usage: make_corpus FOLDER\n");
    return 2;
  }
  for (const ajar::fixtures::TransportScene& scene : ajar::fixtures::transport_scenes())
    ajar::save_description(scene.description, std::string(argv[1]) + "/" + scene.name + ".ajar");
}
