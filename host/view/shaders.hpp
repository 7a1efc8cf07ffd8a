/// The shaders, GLSL 3.30. Eye space: x right, y up, z towards the eye.
#pragma once

namespace palpate::view::shaders {

/// One square per disc, in the disc's plane, `push_back_m` farther from the eye than it is.
constexpr const char* kDiscVertex = R"(#version 330 core
layout(location = 0) in vec3 at_m;
layout(location = 1) in vec3 normal;
layout(location = 2) in float radius_m;
layout(location = 3) in float shade;
layout(location = 4) in float dipped_m;
uniform mat4 view, projection;
uniform float push_back_m, rim;
uniform sampler2D palette;
uniform vec3 unknown_colour;
out vec2 in_disc;
flat out vec3 colour;
flat out vec3 eye_normal;
flat out float strength;
flat out float dipped_mm;
void main() {
    vec2 corner = vec2(gl_VertexID & 1, (gl_VertexID >> 1) & 1) * 2.0 - 1.0;
    vec3 n = normalize(normal);
    vec3 t1 = normalize(cross(n, abs(n.x) < 0.7 ? vec3(1, 0, 0) : vec3(0, 1, 0)));
    corner *= rim;
    vec3 world_m = at_m + radius_m * (corner.x * t1 + corner.y * cross(n, t1));
    vec3 eye_m = (view * vec4(world_m, 1.0)).xyz;
    vec3 to_disc_m = (view * vec4(at_m, 1.0)).xyz;
    eye_normal = mat3(view) * n;
    // A disc that faces away is lit as its mirror image: beyond an outline the shading goes on as before it.
    vec3 away = normalize(to_disc_m);
    eye_normal -= 2.0 * max(dot(eye_normal, away), 0.0) * away;
    eye_m += normalize(eye_m) * push_back_m;
    in_disc = corner;
    strength = shade;
    dipped_mm = dipped_m * 1000.0;
    colour = shade < 0.0 ? unknown_colour : texture(palette, vec2((shade * 255.0 + 0.5) / 256.0, 0.5)).rgb;
    gl_Position = projection * vec4(eye_m, 1.0);
}
)";

/// Sums of colour, normal and dip under a bell over each disc; resolved by kResolveFragment.
constexpr const char* kDiscFragment = R"(#version 330 core
in vec2 in_disc;
flat in vec3 colour;
flat in vec3 eye_normal;
flat in float dipped_mm;
uniform float rim;
layout(location = 0) out vec4 colour_sum;
layout(location = 1) out vec4 normal_sum;
void main() {
    float r2 = dot(in_disc, in_disc);
    if (r2 > rim * rim) discard;
    float weight = (1.0 - r2) * (1.0 - r2) + 1.0e-3;
    colour_sum = vec4(colour * weight, weight);
    normal_sum = vec4(eye_normal, dipped_mm) * weight;
}
)";

/// The dots that mark the undeformed skin over a dip.
constexpr const char* kDotFragment = R"(#version 330 core
in vec2 in_disc;
flat in float strength;
uniform vec4 dot_colour;
layout(location = 0) out vec4 colour_out;
void main() {
    if (dot(in_disc, in_disc) > 1.0) discard;
    colour_out = vec4(dot_colour.rgb, dot_colour.a * smoothstep(0.04, 0.3, strength));
}
)";

/// One triangle over the whole picture.
constexpr const char* kScreenVertex = R"(#version 330 core
out vec2 at;
void main() {
    at = vec2((gl_VertexID << 1) & 2, gl_VertexID & 2);
    gl_Position = vec4(at * 2.0 - 1.0, 0.0, 1.0);
}
)";

/// Lights the summed discs and draws lines of equal dip; the tool's sphere darkens the skin below it (its
/// form factor); background elsewhere. Colour that means a stiffness is lit weakly, or it would no longer be
/// the colour bar's; grey says nothing and may be lit as shape asks.
constexpr const char* kResolveFragment = R"(#version 330 core
in vec2 at;
uniform sampler2D colour_sums, normal_sums, depths;
uniform mat4 projection, inverse_projection;
uniform vec3 light, fill_light, tool_eye_m, top_colour, bottom_colour;
uniform float push_back_m, tool_radius_m, contour_mm;
layout(location = 0) out vec4 colour_out;
void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    vec4 sum = texelFetch(colour_sums, pixel, 0);
    vec4 normal_sum = texelFetch(normal_sums, pixel, 0);
    float steps = normal_sum.w / max(sum.a, 1.0e-3) / contour_mm;
    float per_pixel = length(vec2(dFdx(steps), dFdy(steps)));
    vec3 background = mix(bottom_colour, top_colour, at.y);
    float depth = texelFetch(depths, pixel, 0).r;
    if (depth >= 1.0 || sum.a < 1.0e-3) {
        colour_out = vec4(background, 1.0);
        gl_FragDepth = 1.0;
        return;
    }
    vec3 base = sum.rgb / sum.a;
    vec3 n = normalize(normal_sum.xyz);
    vec4 clip = vec4(at * 2.0 - 1.0, depth * 2.0 - 1.0, 1.0);
    vec4 eye4 = inverse_projection * clip;
    vec3 eye_m = eye4.xyz / eye4.w;
    eye_m -= normalize(eye_m) * push_back_m;
    vec3 to_eye = -normalize(eye_m);
    float key = max(dot(n, light), 0.0);
    float fill = max(dot(n, fill_light), 0.0);
    vec3 to_tool_m = tool_eye_m - eye_m;
    float far_m = max(length(to_tool_m), 1.0e-6);
    float cover = tool_radius_m / max(far_m, tool_radius_m);
    float means = smoothstep(0.05, 0.25, max(base.r, max(base.g, base.b)) - min(base.r, min(base.g, base.b)));
    float open = 1.0 - mix(0.75, 0.25, means) * max(dot(n, to_tool_m / far_m), 0.0) * cover * cover;
    vec3 half_way = normalize(light + to_eye);
    float shine = mix(0.20, 0.05, means) * pow(max(dot(n, half_way), 0.0), 24.0);
    float weakly = means * (1.0 - smoothstep(0.3, 1.5, steps));  // a dip shows by its relief
    float shade = mix(0.42 + 0.74 * key + 0.18 * fill, 0.78 + 0.26 * key + 0.06 * fill, weakly);
    vec3 lit = (base * shade + vec3(shine)) * open;
    if (steps > 0.5) {
        float off = abs(steps - floor(steps + 0.5)) / max(per_pixel, 1.0e-6);
        float apart = 1.0 - smoothstep(0.12, 0.35, per_pixel);  // closer, lines would run together
        lit = mix(lit, vec3(1.0), 0.55 * apart * (1.0 - smoothstep(0.6, 1.6, off)));
    }
    colour_out = vec4(lit, 1.0);
    vec4 shown = projection * vec4(eye_m, 1.0);
    gl_FragDepth = shown.z / shown.w * 0.5 + 0.5;
}
)";

constexpr const char* kMeshVertex = R"(#version 330 core
layout(location = 0) in vec3 at;
layout(location = 1) in vec3 normal;
uniform mat4 view, projection, model;
out vec3 eye_m;
out vec3 eye_normal;
void main() {
    vec4 e = view * model * vec4(at, 1.0);
    eye_m = e.xyz;
    eye_normal = mat3(view) * inverse(transpose(mat3(model))) * normal;
    gl_Position = projection * e;
}
)";

/// `glass` 0: an opaque solid; 1: only its rim, and `body` of it elsewhere. `flat_shade` 1: the plain colour.
constexpr const char* kMeshFragment = R"(#version 330 core
in vec3 eye_m;
in vec3 eye_normal;
uniform vec4 colour;
uniform vec3 light, fill_light;
uniform float glass, body, flat_shade;
layout(location = 0) out vec4 colour_out;
void main() {
    vec3 n = normalize(eye_normal);
    vec3 to_eye = -normalize(eye_m);
    float key = max(dot(n, light), 0.0);
    float fill = max(dot(n, fill_light), 0.0);
    float shine = 0.35 * pow(max(dot(n, normalize(light + to_eye)), 0.0), 40.0);
    vec3 lit = colour.rgb * (0.42 + 0.55 * key + 0.2 * fill) + vec3(shine);
    float rim = pow(1.0 - clamp(dot(n, to_eye), 0.0, 1.0), 2.0);
    float alpha = mix(colour.a, colour.a * mix(body, 1.0, rim), glass);
    colour_out = vec4(mix(lit, colour.rgb, flat_shade), alpha);
}
)";

}  // namespace palpate::view::shaders
