//! A church generated from parameters: nave and aisles under ribbed vaults, an apse, lancets of many coloured panes, a rose.
//!
//! ```text
//!            y = L + 3.65  ___            plan, metres: the nave is 7.3 wide between its walls, the aisles 3.85; bays are 5 long.
//!                        /     \          z: arcades and aisle vaults spring at 5.2 and rise to 7.8, the nave's vault springs at 9.6
//!     y = L   __________|  apse |________ and rises to 14. The sun falls in from the side of large x and from the west.
//!            | aisle : o| nave  |o: aisle
//!            |       :  o       o  :     |
//!     y = 0  |_______:__|_rose__|__:_____|
//!           -8.2   -4.35 -3.65 3.65 4.35 8.2
//! ```
//!
//! | module | what |
//! |---|---|
//! | `model` | meshes by material, boxes, bodies of revolution, swept bars |
//! | `body` | these cut flush with the walls they stand at |
//! | `arch` | pointed arches, vaults, ribs |
//! | `convex_polygons` | convex polygons cut by one another |
//! | `wall` | walls with openings |
//! | `glass` | tracery, panes, cames, the rose |
//! | `furniture` | columns, benches, altar, candles |
//! | `roof` | roofs and gables |
//! | `mesh` | the GLB |
//! | `textures` | stone, tiles, oak |
//! | `scene` | the scene file |
//! | `plan`, `layout` | dimensions; bays, walls and vaults in plan |
//! | `masonry` | walls, vaults and supports, bay by bay |

mod arch;
mod body;
mod convex_polygons;
mod furniture;
mod glass;
mod layout;
mod masonry;
mod mesh;
mod model;
mod plan;
mod roof;
mod scene;
mod textures;
mod wall;

pub use glass::{GlassHue, HUES};
pub use mesh::glb_model;
pub use model::ChurchModel;
pub use plan::ChurchPlan;
pub use scene::{ChurchResolution, scene_text};

use layout::Church;
use plan::SIDES;

/// Builds the church.
pub fn build(plan: &ChurchPlan) -> ChurchModel {
    let mut m = ChurchModel::default();
    let church = Church { plan };
    church.floor(&mut m);
    for bay in 0..plan.bays {
        church.nave_bay(&mut m, bay);
        for s in SIDES {
            church.aisle_bay(&mut m, s, bay);
            church.arcade(&mut m, s, bay);
        }
    }
    church.supports(&mut m);
    church.west(&mut m);
    SIDES.iter().for_each(|s| church.aisle_east(&mut m, *s));
    church.apse(&mut m);
    church.furnish(&mut m);
    roof::build(&mut m, &church);
    m
}
