// How pictures for people are lit, here and in those of the command line: renderers/osmesa/src/look.h has the same
// numbers, and look.test.ts compares them. Colours and shares are of linear light.
import type { Vec3 } from "../core/protocol";

/** A white wall that faces one light of intensity 1 comes out as this. */
export const kLightShare = 0.8;
/** Without lights in the scene, for who looks from `iso`: a key light from the upper left, a weak one from the right. */
export const kKey: Vec3 = [-0.7, 0.3, -1];
export const kFill: Vec3 = [0.05, -0.9, -0.5];
export const kFillShare = 0.16;
/** What no light reaches: light of the sky on what faces `kAmbientToward`, of the ground on what faces away. */
export const kSkyLight: Vec3 = [0.265, 0.29, 0.325];
export const kGroundLight: Vec3 = [0.115, 0.1, 0.085];
export const kAmbientToward: Vec3 = [0.01, -0.05, 0.09];
/** At this distance a lamp is half as bright as close by [m]; beyond, it falls off with the square. */
export const kLampRange = 6;
/** Share of a spot's cone that has full brightness. */
export const kSpotEdge = 0.85;
/** Brighter than this, colours approach white ever more slowly, and keep their hue. */
export const kKnee = 0.7;
/** Contact shadows: how much of its light a floor loses right under a thing, up to which height of the thing over it and
 *  how far beside it, both as shares of a thing's usual size. */
export const kContact = 0.55;
export const kContactReach = 0.7;
export const kContactBlur = 0.16;

export const kSkies = {
  light: { zenith: [0.36, 0.56, 0.8], horizon: [0.86, 0.91, 0.96], nadir: [0.62, 0.63, 0.64] },
  dark: { zenith: [0.07, 0.1, 0.15], horizon: [0.2, 0.24, 0.29], nadir: [0.11, 0.12, 0.14] },
} as const;
