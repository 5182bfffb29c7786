// A material's constants, as nearfield/material_programs.cpp fills them.
layout(std140, binding = 2) uniform Material {
    vec4 base_color;
    vec4 emissive_cutoff;     // w: alpha cutoff
    vec4 metallic_roughness;  // x metallic, y roughness, z: texels in level 0 of the base colour texture, w: its wraps,
                              // wrap_u + 3 * wrap_v as scene::Wrap counts, -1 without one
    vec4 foliage;             // x: 1 where wind moves the picture, else 0
} material;
layout(binding = 0) uniform sampler2D base_color_texture;
layout(binding = 1) uniform sampler2D emissive_texture;
layout(binding = 2) uniform sampler2D metallic_roughness_texture;
layout(binding = 3) uniform sampler2D base_color_nearest;  // the same texels, unfiltered: alpha as the casters test it
