// A game in miniature: a world of one quad, drawn by the engine's far field; checks that the quad is in the picture.
#include <cstdio>

#include "engine/frame/renderer.h"
#include "engine/scene/scene_data.h"

int main() {
    using namespace ff;
    scene::SceneData world;
    world.materials.push_back({.base_color = {0.9f, 0.1f, 0.1f, 1.0f}});
    scene::MeshSource quad;
    for (const Vec3 corner : {Vec3(-5, 0, 0), Vec3(5, 0, 0), Vec3(5, 10, 0), Vec3(-5, 10, 0)}) {
        quad.positions.push_back(corner);
        scene::VertexAttributes attributes{.color = 0xFFFFFFFFu};
        scene::encode_normal({0, 0, 1}, attributes.normal_oct);
        quad.attributes.push_back(attributes);
    }
    quad.indices = {0, 1, 2, 0, 2, 3};
    quad.triangle_materials = {0, 0};
    world.add_instance(world.add_mesh(scene::prepare_mesh(quad, world.materials)), {0, 0, -20}, Mat3(1.0f), 0);
    world.finish(16);

    const scene::StaticScene scene = world.view();
    frame::Casters casters(scene);
    frame::Renderer renderer(scene, casters, nullptr, 160, 120);
    shading::Image image;
    const frame::FrameStats& stats = renderer.draw({.position = {0, 5, 0}}, {}, {.fixed_near_m = 0.0}, image);
    std::printf("%llu pixels of the quad, %llu of sky\n", static_cast<unsigned long long>(stats.pixels.cast_hit),
                static_cast<unsigned long long>(stats.pixels.sky + stats.pixels.cast_miss));
    return stats.pixels.cast_hit > 1000 ? 0 : 1;
}
