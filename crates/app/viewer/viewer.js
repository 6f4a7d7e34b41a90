(()=>{var Gt="ZONALVW1",jt={u8:Uint8Array,u16:Uint16Array,u32:Uint32Array,f32:Float32Array,f16:Uint16Array},k=class extends Error{};async function Re(t){if(typeof DecompressionStream>"u")throw new k("This browser cannot decompress the data (DecompressionStream is missing). Use a version of 2023 or later.");try{let e=new Blob(t).stream().pipeThrough(new DecompressionStream("gzip"));return await new Response(e).arrayBuffer()}catch{throw new k("The data are incomplete or damaged. Reload the page or export it again.")}}function Me(t){let e=o=>new k(`The data are not a solution (${o}).`);if(t.byteLength<16)throw e("too short");let r=new Uint8Array(t);if(String.fromCharCode(...r.subarray(0,8))!==Gt)throw e("unknown format or version");let s=16+new DataView(t).getUint32(8,!0);if(s>t.byteLength||s%8)throw e("the header is truncated");let a;try{a=JSON.parse(new TextDecoder().decode(r.subarray(16,s)))}catch{throw e("the header is not valid JSON")}let i={};for(let[o,{type:c,offset:u,length:h}]of Object.entries(a.arrays??{})){let l=jt[c];if(!l||!Number.isInteger(u)||!Number.isInteger(h)||u<0||h<0||u%8||s+u+h*l.BYTES_PER_ELEMENT>t.byteLength)throw e(`array ${o}`);i[o]=new l(t,s+u,h)}return qt(a,i,e),{...a,arrays:i}}function qt(t,e,r){let n=t.mesh?.vertices,s={position:3,uv:2,surface:1};for(let[a,i]of Object.entries(s))if(e[a]?.length!==i*n)throw r(`size of ${a}`);if(e.curve&&e.curve.length!==4*n)throw r("size of curve");if(!e.index||e.index.length%3||e.index.some(a=>a>=n))throw r("index");if(e.surface.some(a=>a>=t.surfaces.length))throw r("surface");for(let[a,i]of Object.entries(e))if(/^(in)?direct\d+$/.test(a)&&i.length!==3*n)throw r(a)}function et(t,e=()=>{}){let n=[];for(let s=0;s<t.length;s+=4194304){let a;try{a=atob(t.slice(s,s+4194304))}catch{throw new k("The data in this file are damaged. Export it again with zonal export.")}let i=new Uint8Array(a.length);for(let o=0;o<a.length;o++)i[o]=a.charCodeAt(o);n.push(i),e(Math.min(1,(s+4194304)/t.length))}return n}async function _e(t,e=()=>{}){let r;try{r=await fetch(t)}catch{throw new k("The server does not answer. Check that zonal view is running.")}if(!r.ok)throw new k(`The server answered with status ${r.status}. Check that zonal view is running.`);let n=Number(r.headers.get("content-length"))||0,s=r.body.getReader(),a=[],i=0;for(;;){let o;try{o=await s.read()}catch{throw new k("The download was interrupted. Reload the page.")}if(o.done)break;a.push(o.value),i+=o.value.length,n&&e(i/n)}return a}var Fe={busy:500,idle:2e3},tt=t=>new Promise(e=>setTimeout(e,t));async function rt(){try{let t=await fetch("progress.json");return t.ok?await t.json():null}catch{return null}}function Se(t){if(t.error)return`Not solved: ${t.error}`;if(t.done)return"";let e=t.stage?`${t.stage} ${Math.round(100*t.fraction)} %`:"starting";return`Solving (${t.quality}): ${e}`}async function nt(t){for(;;){let e=await rt();if(!e||e.version>0||e.error)return e;t(e),await tt(Fe.busy)}}async function st(t,e,r){for(let n=t;;){let s=await rt();if(!s)return e("The server has ended; the page shows its last data.");e(Se(s)),s.version>n&&(n=s.version,await r()),await tt(s.done?Fe.idle:Fe.busy)}}function at(t,e){let r=n=>JSON.stringify([n.name,n.groups.map(s=>s.name),n.cameras,n.origin,n.bounds]);return r(t)===r(e)&&!t.volume==!e.volume}function B(t,{vertex:e,fragment:r}){let n=t.createProgram();for(let[i,o]of[[t.VERTEX_SHADER,e],[t.FRAGMENT_SHADER,r]]){let c=t.createShader(i);if(t.shaderSource(c,o),t.compileShader(c),!t.getShaderParameter(c,t.COMPILE_STATUS)&&!t.isContextLost())throw new Error(t.getShaderInfoLog(c));t.attachShader(n,c)}if(t.linkProgram(n),!t.getProgramParameter(n,t.LINK_STATUS)&&!t.isContextLost())throw new Error(t.getProgramInfoLog(n));let s=new Map;for(let i=0;i<t.getProgramParameter(n,t.ACTIVE_UNIFORMS);i++){let{name:o,type:c}=t.getActiveUniform(n,i);s.set(o.replace(/\[0\]$/,""),{type:c,at:t.getUniformLocation(n,o)})}let a={[t.FLOAT]:(i,o)=>t.uniform1f(i,o),[t.FLOAT_VEC2]:(i,o)=>t.uniform2fv(i,o),[t.FLOAT_VEC3]:(i,o)=>t.uniform3fv(i,o),[t.FLOAT_VEC4]:(i,o)=>t.uniform4fv(i,o),[t.FLOAT_MAT4]:(i,o)=>t.uniformMatrix4fv(i,!1,o)};return{free:()=>t.deleteProgram(n),use(i){t.useProgram(n);for(let[o,c]of Object.entries(i))this.set(o,c)},set(i,o){let c=s.get(i);c&&(Array.isArray(o)&&o.length===3&&o[2]instanceof WebGLTexture?(t.activeTexture(t.TEXTURE0+o[0]),t.bindTexture(o[1],o[2]),t.uniform1i(c.at,o[0])):(a[c.type]??((u,h)=>t.uniform1i(u,h)))(c.at,o))}}}function G(t,e,r,n,s,a,i,o=t.NEAREST){let c=t.createTexture();return t.bindTexture(t.TEXTURE_2D,c),t.pixelStorei(t.UNPACK_ALIGNMENT,1),t.texImage2D(t.TEXTURE_2D,0,e,s,a,0,r,n,i),oe(t,t.TEXTURE_2D,o,o,t.CLAMP_TO_EDGE),c}function oe(t,e,r,n,s){t.texParameteri(e,t.TEXTURE_MIN_FILTER,r),t.texParameteri(e,t.TEXTURE_MAG_FILTER,n),t.texParameteri(e,t.TEXTURE_WRAP_S,s),t.texParameteri(e,t.TEXTURE_WRAP_T,s),e===t.TEXTURE_3D&&t.texParameteri(e,t.TEXTURE_WRAP_R,s)}function Ne(t,e,r){let n=Math.max(1,Math.ceil(e.length/512)),s=new Float32Array(4*512*r*n);return e.forEach((a,i)=>{a.forEach((o,c)=>s.set(o,4*((i&511)+512*(r*(i>>9)+c))))}),G(t,t.RGBA32F,t.RGBA,t.FLOAT,512,r*n,s)}function ot(t,e,r,n,s,a){let i={textures:[],buffers:[],frames:[]},o=(p,E,b,g,T,F)=>{let R=G(t,p,E,b,g,T,null,F);return i.textures.push(R),R},c=(p,E,b=t.NEAREST)=>o(t.RGBA16F,t.RGBA,t.HALF_FLOAT,p,E,b),u=p=>{let E=t.createFramebuffer();t.bindFramebuffer(t.FRAMEBUFFER,E);for(let[b,g]of p)g instanceof WebGLTexture?t.framebufferTexture2D(t.FRAMEBUFFER,b,t.TEXTURE_2D,g,0):t.framebufferRenderbuffer(t.FRAMEBUFFER,b,t.RENDERBUFFER,g);return t.drawBuffers(p.filter(([b])=>b!==t.DEPTH_ATTACHMENT).map(([b])=>b)),i.frames.push(E),E},h=p=>{let E=t.createRenderbuffer();return t.bindRenderbuffer(t.RENDERBUFFER,E),t.renderbufferStorageMultisample(t.RENDERBUFFER,s,p,e,r),i.buffers.push(E),E},l=c(e,r),f=o(t.DEPTH_COMPONENT24,t.DEPTH_COMPONENT,t.UNSIGNED_INT,e,r),d=u([[t.COLOR_ATTACHMENT0,l],[t.DEPTH_ATTACHMENT,f]]),m=s>1?u([[t.COLOR_ATTACHMENT0,h(t.RGBA16F)],[t.DEPTH_ATTACHMENT,h(t.DEPTH_COMPONENT24)]]):d,v={width:e,height:r,image:l,depth:f,resolved:d,multisampled:m,medium:null};if(a){let p=Math.max(1,Math.round(e*n)),E=Math.max(1,Math.round(r*n)),b=c(p,E),g=c(p,E),T=c(p,E);v.medium={width:p,height:E,scattered:b,transmittance:g,paneTint:T,frame:u([[t.COLOR_ATTACHMENT0,b],[t.COLOR_ATTACHMENT1,g]]),paneFrame:u([[t.COLOR_ATTACHMENT0,T]])}}return v.free=()=>{i.frames.forEach(p=>t.deleteFramebuffer(p)),i.textures.forEach(p=>t.deleteTexture(p)),i.buffers.forEach(p=>t.deleteRenderbuffer(p))},v}var w=(t,e)=>[t[0]+e[0],t[1]+e[1],t[2]+e[2]],N=(t,e)=>[t[0]-e[0],t[1]-e[1],t[2]-e[2]],y=(t,e)=>[t[0]*e,t[1]*e,t[2]*e],_=(t,e)=>t[0]*e[0]+t[1]*e[1]+t[2]*e[2],S=(t,e)=>[t[1]*e[2]-t[2]*e[1],t[2]*e[0]-t[0]*e[2],t[0]*e[1]-t[1]*e[0]],H=t=>Math.hypot(t[0],t[1],t[2]),P=(t,e,r)=>[0,1,2].map(n=>t[n]+(e[n]-t[n])*r);function A(t){let e=H(t);return e>0?y(t,1/e):[0,0,0]}function W(t,e,r){let n=Math.cos(r),s=Math.sin(r);return w(w(y(t,n),y(S(e,t),s)),y(e,_(e,t)*(1-n)))}function Vt(t,e){let r=new Array(16).fill(0);for(let n=0;n<4;n++)for(let s=0;s<4;s++)for(let a=0;a<4;a++)r[4*n+s]+=t[4*a+s]*e[4*n+a];return r}var Yt=4/3;function C(t,e){let r=A(t.forward),n=A(S(r,t.up)),s=S(n,r),i=Math.tan(t.fov*Math.PI/360)/Math.max(e,Yt);return{forward:r,right:n,up:s,tanX:i*e,tanY:i}}function it(t,e,r,n){let{right:s,up:a,forward:i}=e,o=[s[0],a[0],-i[0],0,s[1],a[1],-i[1],0,s[2],a[2],-i[2],0,-_(s,t),-_(a,t),_(i,t),1],c=[1/e.tanX,0,0,0,0,1/e.tanY,0,0,0,0,-(n+r)/(n-r),-1,0,0,-2*n*r/(n-r),0];return Vt(c,o)}function ct(t,e,r){return A(w(t.forward,w(y(t.right,(2*e-1)*t.tanX),y(t.up,(1-2*r)*t.tanY))))}function ut(t,e,r){let n=N(r,e),s=_(n,t.forward);return s<=0?null:[.5+.5*_(n,t.right)/(s*t.tanX),.5-.5*_(n,t.up)/(s*t.tanY)]}var ke=new Float32Array(1),Kt=new Uint32Array(ke.buffer),O=(()=>{let t=new Float32Array(65536);for(let e=0;e<65536;e++){let r=e>>10&31,n=e&1023,s=r===0?n*2**-24:r===31?1/0:(1024+n)*2**(r-25);t[e]=e&32768?-s:s}return t})();function Wt(t){if(t!==t)return 0;ke[0]=t;let e=Kt[0],r=e>>>16&32768,n=(e>>>23&255)-127;return n>15?r|31743:n>=-14?r|Math.min((n+15<<10|e>>>13&1023)+(e>>>12&1),31743):r|Math.round(Math.abs(ke[0])*2**24)}function ie(t,e=new Uint16Array(t.length)){for(let r=0;r<t.length;r++)e[r]=Wt(t[r]);return e}function Zt(t,e,r){for(let n=0;n<t.length;n++)t[n]+=r*O[e[n]]}function ce(t,e,r,n){let s=new Float32Array(n);return t.groups.forEach((a,i)=>{for(let o of e){let c=t.arrays[o+i];c&&r[i]&&Zt(s,c,r[i]*a.scales[o])}}),s}function ht(t,e){return t.surfaces.map(r=>r.emission.map(n=>n*(r.group===null?1:e[r.group])))}function lt(t,e){return[0,1,2].map(r=>t.groups.reduce((n,s,a)=>n+e[a]*s.background[r],0))}function ft(t,e,r){return r==="total"||e==="error"?t[e]:e==="radiosity"?t[r].map((n,s)=>n*t.reflectance[s]):t[r]}function ue(t,e,r){let{arrays:n,groups:s,surfaces:a}=t,i=m=>{let v=n[m];return v?[0,1,2].map(p=>v[3*e+p]):[0,0,0]},o=m=>s.reduce((v,p,E)=>{let b=i(m+E);return v.map((g,T)=>g+r[E]*b[T])},[0,0,0]),c=o("zoneIndirect"),u=o("zoneDirect"),h=i("zoneReflectance"),l=a[n.zoneSurface[e]],f=l.group===null?1:r[l.group],d=i("zoneEmission").map(m=>m*f);return{indirect:c,direct:u,irradiance:c.map((m,v)=>m+u[v]),radiosity:h.map((m,v)=>d[v]+m*(c[v]+u[v])),reflectance:h,error:i("zoneError")}}function dt(t){let e=t.length/3,r=[1/0,1/0,1/0],n=[-1/0,-1/0,-1/0];for(let c=0;c<t.length;c++)r[c%3]=Math.min(r[c%3],t[c]),n[c%3]=Math.max(n[c%3],t[c]);let s=2**17/Math.max(...n.map((c,u)=>c-r[u]),1e-30),a=(c,u)=>Math.min(Math.round((t[3*c+u]-r[u])*s),2**17-1),i=new Map,o=new Uint32Array(e);for(let c=0;c<e;c++){let u=(a(c,0)*131072+a(c,1))*131072+a(c,2),h=i.get(u);h===void 0?i.set(u,c):t.copyWithin(3*c,3*h,3*h+3),o[c]=h??c}return o}function Jt({order:t},e){let r=new Map,n=(i,o)=>Math.min(e[i],e[o])*2**26+Math.max(e[i],e[o]),s=i=>{for(let o=0;o<t.length;o+=3)for(let c=0;c<3;c++)i(t[o+c],t[o+(c+1)%3],o)};s((i,o)=>r.set(n(i,o),(r.get(n(i,o))??0)+1));let a=[];return s((i,o,c)=>r.get(n(i,o))===1&&a.push([i,o,c])),a}function Qt(t,e,r){let n=l=>[t[3*l],t[3*l+1],t[3*l+2]],s=t.reduce((l,f)=>Math.max(l,Math.abs(f)),0),[a,i]=[s/128,4e-6*s],o=l=>Math.floor(l/a)+256,c=(l,f,d)=>(l*512+f)*512+d,u=new Map,h=(l,f)=>{u.has(l)?u.get(l).at(-1)!==f&&u.get(l).push(f):u.set(l,[f])};return e.forEach(([l,f],d)=>{let[m,v]=[n(l),n(f)],p=Math.ceil(H(N(v,m))/a);for(let E=0;E<p;E++){let[b,g]=[P(m,v,E/p),P(m,v,(E+1)/p)],[T,F]=[0,1,2].map(R=>[Math.min(b[R],g[R])-i,Math.max(b[R],g[R])+i].map(o)).reduce(([R,U],[$,ne])=>[[...R,$],[...U,ne]],[[],[]]);for(let R=T[0];R<=F[0];R++)for(let U=T[1];U<=F[1];U++)for(let $=T[2];$<=F[2];$++)h(c(R,U,$),d)}}),(l,f)=>{let[d,m]=e[l],v=P(n(d),n(m),f);return u.get(c(...v.map(o)))?.some(p=>{let[E,b]=e[p];if(p===l||r[E]===r[d]&&r[b]===r[m])return!1;let g=n(E),T=N(n(b),g),F=_(N(v,g),T)/_(T,T);return F>0&&F<1&&H(N(v,P(g,n(b),F)))<i})??!1}}function mt(t,e,r){let n=Jt(t,e),s=Qt(r,n,e),a=[],i=[],o=0;return n.forEach(([c,u,h],l)=>{for(;h>=t.runs[o].first+t.runs[o].count;)o++;[.5,.25,.75].some(f=>s(l,f))&&(i[o]??={...t.runs[o],first:a.length,count:0},a.push(c,u),i[o].count+=2)}),{lines:Uint32Array.from(a),runs:i.filter(Boolean)}}var Pe={sunOpaque:4,sunNear:5,sunFar:6,sunTintNear:7,sunTintAll:8,sunDepth:9},er=2,pt=4,De=t=>t===0?"vec3 sunlight(vec3 p, vec3 n, float turn) { return vec3(0.0); }":`
const int SUNS = ${t};
const int SEARCH = 16;
uniform highp sampler2DArray sunOpaque, sunNear, sunFar;
uniform mediump sampler2DArray sunTintNear, sunTintAll;
${Array.from({length:t},(e,r)=>`uniform highp sampler3D sunDepth${r};`).join(`
`)}
uniform mat4 sunSpace[SUNS];
// One over width, height and depth of the map, 1/m; tangent of the angular radius.
uniform vec4 sunScale[SUNS];
uniform vec3 sunLight[SUNS];
uniform vec3 sunBoxLow, sunBoxHigh;
uniform int sunSamples;
uniform bool sunPanes;

vec3 sunAxis(int k, int row) { return vec3(sunSpace[k][0][row], sunSpace[k][1][row], sunSpace[k][2][row]); }
vec3 sunNodes(int k) {
${Array.from({length:t},(e,r)=>`  if (k == ${r}) return vec3(textureSize(sunDepth${r}, 0));`).join(`
`)}
return vec3(1.0);
}
vec3 sunDepthAt(int k, vec3 at) {
${Array.from({length:t},(e,r)=>`  if (k == ${r}) return texture(sunDepth${r}, at).rgb;`).join(`
`)}
return vec3(0.0);
}
// exp(−D) at a point; outside of the medium from where its light enters it.
vec3 sunPassed(int k, vec3 p) {
vec3 towards = -sunAxis(k, 2);
towards = mix(towards, vec3(1e-7), lessThan(abs(towards), vec3(1e-7)));
vec3 one = (sunBoxLow - p) / towards, two = (sunBoxHigh - p) / towards;
vec3 lo = min(one, two), hi = max(one, two);
float enter = max(max(lo.x, max(lo.y, lo.z)), 0.0), leave = min(hi.x, min(hi.y, hi.z));
if (enter >= leave) return vec3(1.0);
vec3 at = clamp((p + enter * towards - sunBoxLow) / (sunBoxHigh - sunBoxLow), 0.0, 1.0).zyx;
vec3 nodes = sunNodes(k);
return exp(-sunDepthAt(k, (at * (nodes - 1.0) + 0.5) / nodes));
}
ivec3 sunTexel(int k, vec2 q) {
ivec2 size = textureSize(sunOpaque, 0).xy;
return ivec3(clamp(ivec2(floor(q * sunScale[k].xy * vec2(size))), ivec2(0), size - 1), k);
}
float sunBias(int k) { return 2e-5 / sunScale[k].z; }
// Width and height of a texel, m.
vec2 sunTexelSize(int k) { return 1.0 / (vec2(textureSize(sunOpaque, 0).xy) * sunScale[k].xy); }
// Distance, m, of the surface in the map before the receiver's plane at an offset.
float sunGap(int k, vec3 q, vec2 slope, vec2 offset) {
ivec3 at = sunTexel(k, q.xy + offset);
vec2 texel = sunTexelSize(k);
vec2 centre = (vec2(at.xy) + 0.5) * texel - q.xy;
// Rasterisers round vertices to a fraction of a texel, a sixteenth at worst.
float margin = 1e-4 * length(centre) * (1.0 + dot(slope, slope)) + 0.13 * dot(abs(slope), texel);
return q.z + dot(slope, centre) - margin - texelFetch(sunOpaque, at, 0).r / sunScale[k].z;
}
// The texel of the panes at an offset. Where a wall before a pane ends in the texel, the map lacks the pane: a texel beside it has it.
ivec3 sunPaneTexel(int k, vec2 q) {
ivec3 at = sunTexel(k, q);
if (texelFetch(sunFar, at, 0).r > 0.0) return at;
ivec3 last = ivec3(textureSize(sunFar, 0).xy - 1, k);
for (int i = 0; i < 9; i++) {
ivec3 beside = clamp(at + ivec3(i % 3 - 1, i / 3 - 1, 0), ivec3(0, 0, k), last);
if (texelFetch(sunFar, beside, 0).r > 0.0) return beside;
}
return at;
}
// Depth in the map down to which panes lie before a point.
float sunPaneDepth(int k, vec3 q) {
vec2 texel = sunTexelSize(k);
return (q.z + sunBias(k) + float(${er}) * max(texel.x, texel.y)) * sunScale[k].z;
}
// Transmittance of the panes between the sun and a depth of the map; the maps hold its square root.
vec3 sunTint(int k, vec3 q, vec2 offset) {
if (!sunPanes) return vec3(1.0);
ivec3 at = sunPaneTexel(k, q.xy + offset);
float z = sunPaneDepth(k, q);
vec3 root = vec3(1.0);
if (z >= texelFetch(sunFar, at, 0).r) root = texelFetch(sunTintAll, at, 0).rgb;
else if (z >= texelFetch(sunNear, at, 0).r) root = texelFetch(sunTintNear, at, 0).rgb;
return root * root;
}
// Distance, m, of the last pane before a depth of the map, at least that of the bias; 0 without.
float sunPaneGap(int k, vec3 q, vec2 offset) {
if (!sunPanes) return 0.0;
ivec3 at = sunPaneTexel(k, q.xy + offset);
float z = sunPaneDepth(k, q), far = texelFetch(sunFar, at, 0).r;
float pane = z >= far ? far : texelFetch(sunNear, at, 0).r;
return pane > 0.0 && z >= pane ? max(q.z - pane / sunScale[k].z, sunBias(k)) : 0.0;
}
vec2 sunDisc(float radius, int i, float turn) {
float angle = 2.39996323 * float(i) + 6.28318531 * turn;
return radius * vec2(cos(angle), sin(angle));
}
// True where a ray is blocked near the distance at which it passes the offset.
bool sunBlocked(int k, vec3 q, vec2 slope, vec2 ray, float from, float texel) {
float d = sunGap(k, q, slope, ray * from);
if (d <= sunBias(k)) return false;
return length(ray) * abs(d - from) < texel || sunGap(k, q, slope, ray * d) > sunBias(k);
}
// True where a surface lies a few texels before the point in its texel or one beside it: at the seam of two walls a texel
// may hold neither or the wrong one. Where it holds what lies behind the point, any surface before it counts.
bool sunTouched(int k, vec3 q, vec2 slope, vec2 texel) {
float width = dot(texel, 1.0 + abs(slope));
float reach = sunGap(k, q, slope, vec2(0.0)) < -0.5 * width ? 1e30 : 4.0 * width;
for (int i = 0; i < 9; i++) {
float d = sunGap(k, q, slope, texel * vec2(i % 3 - 1, i / 3 - 1));
if (d > sunBias(k) && d < reach) return true;
}
return false;
}
// Mean transmittance of panes, zero for blocked rays, at a surface point.
vec3 sunSeen(int k, vec3 p, vec3 n, float turn) {
vec3 q = (sunSpace[k] * vec4(p, 1.0)).xyz;
vec2 slope = vec2(dot(n, sunAxis(k, 0)), dot(n, sunAxis(k, 1))) / -dot(n, sunAxis(k, 2));
vec2 texels = sunTexelSize(k);
if (sunTouched(k, q, slope, texels)) return vec3(0.0);
float texel = max(texels.x, texels.y), tangent = sunScale[k].w;
float near = 1e30, far = 0.0, glass = 0.0, panes = 0.0;
int blocked = 0;
for (int i = 0; i < SEARCH; i++) {
// Offsets are denser in the middle, where near surfaces block the narrow end of the cone.
float x = float(i) / float(SEARCH - 1), offset = x * x * tangent * q.z;
vec2 o = sunDisc(offset, i, turn);
float d = sunGap(k, q, slope, o);
if (d > sunBias(k) && offset <= tangent * d + texel) {
near = min(near, d);
far = max(far, d);
if (offset <= tangent * d) blocked++;
}
float g = sunPaneGap(k, q, o);
if (g > 0.0 && offset <= tangent * g + texel) {
glass += g;
panes += 1.0;
}
}
if (blocked == SEARCH) return vec3(0.0);
// Panes that were not met are as far as the frames beside them.
glass = panes > 0.0 ? glass / panes : far;
if (far == 0.0 && panes == 0.0) return vec3(1.0);
// At least the filter of a texel.
float width = max(tangent, 0.7 * texel / max(max(far, glass), texel));
vec3 sum = vec3(0.0);
for (int i = 0; i < sunSamples; i++) {
vec2 ray = sunDisc(width * sqrt((float(i) + 0.5) / float(sunSamples)), i, turn);
if (far > 0.0 && (sunBlocked(k, q, slope, ray, far, texel) || sunBlocked(k, q, slope, ray, near, texel))) continue;
if (panes > 0.0 && sunBlocked(k, q, slope, ray, glass, texel)) continue;
sum += sunTint(k, q, ray * glass);
}
return sum / float(sunSamples);
}
// H_dir of all suns at a surface point.
vec3 sunlight(vec3 p, vec3 n, float turn) {
vec3 sum = vec3(0.0);
for (int k = 0; k < SUNS; k++) {
float cosine = -dot(n, sunAxis(k, 2));
if (cosine <= 1e-4 || sunLight[k] == vec3(0.0)) continue;
vec3 seen = sunSeen(k, p, n, turn);
if (seen != vec3(0.0)) sum += cosine * seen * sunPassed(k, p) * sunLight[k];
}
return sum;
}
// G_dir of all suns at a point of the medium, by one ray to each sun.
vec3 sunFluence(vec3 p, float turn, float radius) {
vec3 sum = vec3(0.0);
for (int k = 0; k < SUNS; k++) {
if (sunLight[k] == vec3(0.0)) continue;
vec3 q = (sunSpace[k] * vec4(p, 1.0)).xyz;
vec2 ray = sunDisc(sunScale[k].w * sqrt(radius), 0, turn);
float d = sunGap(k, q, vec2(0.0), vec2(0.0));
if (d <= sunBias(k)) d = sunPaneGap(k, q, vec2(0.0));
vec2 offset = ray * d;
if (sunGap(k, q, vec2(0.0), offset) > sunBias(k)) continue;
sum += sunTint(k, q, offset) * sunPassed(k, p) * sunLight[k];
}
return sum;
}`,he=`#version 300 es
precision highp float;
precision highp int;
`,vt={vertex:`${he}
layout(location = 0) in vec3 position;
uniform mat4 toMap;
uniform float behind;
void main() {
gl_Position = toMap * vec4(position, 1.0);
gl_Position.z += behind;
}`,fragment:`${he}
void main() {}`},xt={vertex:`${he}
layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;
layout(location = 2) in uint pane;
uniform mat4 toMap;
flat out vec3 vNormal;
flat out int vPane;
void main() {
vNormal = normal;
vPane = int(pane);
gl_Position = toMap * vec4(position, 1.0);
}`,fragment:`${he}
flat in vec3 vNormal;
flat in int vPane;
uniform highp sampler2D panes;
uniform highp sampler2DArray sunOpaque;
uniform vec3 towards;
uniform int layer;
out vec4 colour;
void main() {
if (gl_FragCoord.z > texelFetch(sunOpaque, ivec3(gl_FragCoord.xy, layer), 0).r + 2e-5) discard;
float cosine = max(abs(dot(towards, vNormal)), 1e-4);
colour = vec4(exp(-0.5 * texelFetch(panes, ivec2(vPane & 511, vPane >> 9), 0).rgb / cosine), 1.0);
}`};var Et={one:4096,several:2048},tr=1.02,rr=3,nr=16,Ue=48,sr=(t,e)=>t.reduce((r,n)=>Math.max(r,Math.abs(_(n,e))),1e-9);function ar(t,e){let r=Array.from({length:8},(o,c)=>[0,1,2].map(u=>e[c>>u&1][u])),n=A(t),s=A(S(Math.abs(n[2])<.9?[0,0,1]:[1,0,0],n)),a=S(n,s),i=null;for(let o=0;o<Ue;o++){let[c,u]=[Math.cos(Math.PI*o/(2*Ue)),Math.sin(Math.PI*o/(2*Ue))],h=s.map((d,m)=>c*d+u*a[m]),l=S(n,h),f=[h,l,n].map(d=>tr*sr(r,d));(!i||f[0]*f[1]<i.half[0]*i.half[1])&&(i={right:h,up:l,towards:n,half:f})}return i}function or({right:t,up:e,towards:r,half:n}){let s=a=>[t[a],e[a],-r[a],0];return[...s(0),...s(1),...s(2),...n,1]}function bt({right:t,up:e,towards:r,half:n}){let s=a=>[t[a]/n[0],e[a]/n[1],-r[a]/n[2],0];return[...s(0),...s(1),...s(2),0,0,0,1]}var le=class{constructor(e,r,{mesh:n,panes:s,volume:a},i){let o=(r.suns??[]).slice(0,pt);if(Object.assign(this,{gl:e,suns:o,mesh:n,panes:s,volume:a}),this.count=o.length,this.drawn=0,!this.count)return;this.maps=o.map(l=>ar(l.towards,r.bounds));let c=i||this.count>1?Et.several:Et.one;this.side=Math.min(c,e.getParameter(e.MAX_TEXTURE_SIZE));let[u,h]=[s?this.side:1,this.count];this.textures={sunOpaque:this.array(e.DEPTH_COMPONENT24,this.side,h),sunNear:this.array(e.DEPTH_COMPONENT16,u,h),sunFar:this.array(e.DEPTH_COMPONENT16,u,h),sunTintNear:this.array(e.RGB10_A2,u,h),sunTintAll:this.array(e.RGB10_A2,u,h)},this.depths=o.map((l,f)=>this.depthTexture(l,r.arrays[`sunDepth${f}`])),this.texel=Math.max(...this.maps.flatMap(({half:l})=>[l[0],l[1]]))*2/this.side,this.bytes=h*(4*this.side**2+(s?12*this.side**2:0))}array(e,r,n){let{gl:s}=this,a=s.createTexture();s.bindTexture(s.TEXTURE_2D_ARRAY,a),s.texStorage3D(s.TEXTURE_2D_ARRAY,1,e,r,r,n);for(let i of[s.TEXTURE_MIN_FILTER,s.TEXTURE_MAG_FILTER])s.texParameteri(s.TEXTURE_2D_ARRAY,i,s.NEAREST);for(let i of[s.TEXTURE_WRAP_S,s.TEXTURE_WRAP_T])s.texParameteri(s.TEXTURE_2D_ARRAY,i,s.CLAMP_TO_EDGE);return a}depthTexture(e,r){let{gl:n}=this,s=n.createTexture();n.bindTexture(n.TEXTURE_3D,s),n.pixelStorei(n.UNPACK_ALIGNMENT,1);let a=r?[e.depthDims[2],e.depthDims[1],e.depthDims[0]]:[1,1,1],i=r?ie(Float32Array.from(r,o=>O[o]*e.depthScale)):new Uint16Array(3);n.texImage3D(n.TEXTURE_3D,0,n.RGB16F,...a,0,n.RGB,n.HALF_FLOAT,i);for(let o of[n.TEXTURE_MIN_FILTER,n.TEXTURE_MAG_FILTER])n.texParameteri(n.TEXTURE_3D,o,n.LINEAR);for(let o of[n.TEXTURE_WRAP_S,n.TEXTURE_WRAP_T,n.TEXTURE_WRAP_R])n.texParameteri(n.TEXTURE_3D,o,n.CLAMP_TO_EDGE);return s}free(){this.count&&[...Object.values(this.textures),...this.depths].forEach(e=>this.gl.deleteTexture(e))}prepare(){if(!this.count||this.drawn)return;let{gl:e}=this,r={depth:B(e,vt),tint:B(e,xt)},n=e.createFramebuffer();e.bindFramebuffer(e.FRAMEBUFFER,n),e.viewport(0,0,this.side,this.side),e.enable(e.DEPTH_TEST),e.depthMask(!0),this.maps.forEach((s,a)=>{let i=bt(s);this.attach(a,null,"sunOpaque"),e.clearDepth(1),e.clear(e.DEPTH_BUFFER_BIT),r.depth.use({toMap:i}),e.bindVertexArray(this.mesh.array);for(let[o,c]of[[e.TRIANGLES,this.mesh.triangles],[e.LINES,this.mesh.cracks]]){e.bindBuffer(e.ELEMENT_ARRAY_BUFFER,c.buffer),r.depth.set("behind",o===e.LINES?nr*this.texel/s.half[2]:0);for(let u of c.runs)e.drawElements(o,u.count,e.UNSIGNED_INT,4*u.first)}this.panes&&this.drawPanes(r,s,a)}),e.bindVertexArray(null),e.clearDepth(1),e.depthFunc(e.LESS),e.bindFramebuffer(e.FRAMEBUFFER,null),e.deleteFramebuffer(n),Object.values(r).forEach(s=>s.free()),this.drawn++}drawPanes({tint:e,depth:r},n,s){let{gl:a,panes:i}=this,o=bt(n),c=()=>a.drawElements(a.TRIANGLES,3*i.count,a.UNSIGNED_INT,0);a.bindVertexArray(i.array),a.clearColor(1,1,1,1),e.use({toMap:o,towards:n.towards,layer:s,panes:[0,a.TEXTURE_2D,i.table],sunOpaque:[1,a.TEXTURE_2D_ARRAY,this.textures.sunOpaque]}),this.attach(s,"sunTintNear","sunNear"),a.clear(a.COLOR_BUFFER_BIT|a.DEPTH_BUFFER_BIT),c(),this.attach(s,"sunTintAll","sunFar"),a.clearDepth(0),a.clear(a.COLOR_BUFFER_BIT|a.DEPTH_BUFFER_BIT),a.disable(a.DEPTH_TEST),a.enable(a.BLEND),a.blendFunc(a.ZERO,a.SRC_COLOR),c(),a.disable(a.BLEND),a.enable(a.DEPTH_TEST),a.depthFunc(a.GREATER),a.colorMask(!1,!1,!1,!1),c(),a.colorMask(!0,!0,!0,!0),a.depthFunc(a.LESS),a.clearDepth(1)}attach(e,r,n){let{gl:s,textures:a}=this;s.framebufferTextureLayer(s.FRAMEBUFFER,s.COLOR_ATTACHMENT0,r?a[r]:null,0,e),s.framebufferTextureLayer(s.FRAMEBUFFER,s.DEPTH_ATTACHMENT,a[n],0,e),s.drawBuffers([r?s.COLOR_ATTACHMENT0:s.NONE])}uniforms(e,r,n){if(!this.count)return{};let{gl:s,suns:a,maps:i}=this,o={crackInset:rr*this.texel,sunSpace:i.flatMap(or),sunScale:i.flatMap(({half:c},u)=>[...c.map(h=>.5/h),Math.tan(.5*a[u].angularDiameter)]),sunLight:a.flatMap(c=>c.irradiance.map(u=>u*e[c.group]*r)),sunBoxLow:this.volume?.min??[0,0,0],sunBoxHigh:this.volume?.max??[0,0,0],sunSamples:n,sunPanes:!!this.panes};for(let[c,u]of Object.entries(this.textures))o[c]=[Pe[c],s.TEXTURE_2D_ARRAY,u];return this.depths.forEach((c,u)=>o[`sunDepth${u}`]=[Pe.sunDepth+u,s.TEXTURE_3D,c]),o}};var ir=3e4;async function cr(t,e,r){let n=t.getExtension("EXT_texture_filter_anisotropic"),s=t.getParameter(t.MAX_TEXTURE_SIZE),a=[];for(let i=0;i<e.textures;i++){let o=new Blob([e.arrays[`texture${i}`]],{type:"image/png"}),c={colorSpaceConversion:"none",premultiplyAlpha:"none"},u=await createImageBitmap(o,c);Math.max(u.width,u.height)>s&&(u=await createImageBitmap(o,{...c,resizeWidth:Math.min(u.width,s),resizeHeight:Math.min(u.height,s)}));let h=t.createTexture();t.bindTexture(t.TEXTURE_2D,h),t.pixelStorei(t.UNPACK_ALIGNMENT,1),t.texImage2D(t.TEXTURE_2D,0,t.SRGB8_ALPHA8,t.RGBA,t.UNSIGNED_BYTE,u),t.generateMipmap(t.TEXTURE_2D),oe(t,t.TEXTURE_2D,t.LINEAR_MIPMAP_LINEAR,t.LINEAR,t.REPEAT),n&&t.texParameterf(t.TEXTURE_2D,n.TEXTURE_MAX_ANISOTROPY_EXT,4),u.close(),a.push(h),r((i+1)/e.textures)}return a}function L(t,e,r,n,s,{integer:a=!1,normalized:i=!1}={}){let o=t.createBuffer();return t.bindBuffer(t.ARRAY_BUFFER,o),t.bufferData(t.ARRAY_BUFFER,r,t.STATIC_DRAW),t.enableVertexAttribArray(e),a?t.vertexAttribIPointer(e,n,s,0,0):t.vertexAttribPointer(e,n,s,i,0,0),o}function ur(t){let{index:e,surface:r}=t.arrays,n=t.surfaces.map(c=>`${c.texture??""},${c.emissionTexture??""}`),s=new Map;for(let c=0;c<e.length;c+=3){let u=r[e[c]];s.has(n[u])||s.set(n[u],{texture:t.surfaces[u].texture,emissionTexture:t.surfaces[u].emissionTexture,triangles:[]}),s.get(n[u]).triangles.push(c)}let a=new Uint32Array(e.length),i=[],o=0;for(let{triangles:c,...u}of s.values()){i.push({...u,first:o,count:3*c.length});for(let h of c)for(let l=0;l<3;l++)a[o++]=e[h+l]}return{order:a,runs:i}}function hr({position:t,index:e}){let r=new Int16Array(4*t.length/3),n=new Float32Array(t.length/3);for(let s=0;s<e.length;s+=3){let[a,i,o]=[3*e[s],3*e[s+1],3*e[s+2]],c=S([0,1,2].map(h=>t[i+h]-t[a+h]),[0,1,2].map(h=>t[o+h]-t[a+h])),u=H(c);for(let h of[a,i,o])u>n[h/3]&&(n[h/3]=u,c.forEach((l,f)=>r[4*h/3+f]=Math.round(32767*l/u)))}return r}function lr(t,e){let{arrays:r}=e,n=dt(r.position),s=t.createVertexArray();t.bindVertexArray(s);let a=L(t,3,new Float32Array(r.position.length),3,t.FLOAT),i=[L(t,0,r.position,3,t.FLOAT),L(t,1,r.uv,2,t.FLOAT),L(t,2,r.surface,1,t.UNSIGNED_SHORT,{integer:!0}),a,L(t,4,hr(r),4,t.SHORT,{normalized:!0})];r.curve?i.push(L(t,5,r.curve,4,t.FLOAT)):t.vertexAttrib4f(5,0,0,0,0);let o=ur(e),c=mt(o,n,r.position),u=[[o.order,o.runs],[c.lines,c.runs]].map(([h,l])=>{let f=t.createBuffer();return t.bindBuffer(t.ELEMENT_ARRAY_BUFFER,f),t.bufferData(t.ELEMENT_ARRAY_BUFFER,h,t.STATIC_DRAW),i.push(f),{buffer:f,runs:l}});return t.bindVertexArray(null),{array:s,light:a,buffers:i,triangles:u[0],cracks:u[1]}}function fr(t,e){let{panePosition:r,paneNormal:n,paneOf:s,paneIndex:a}=e.arrays;if(!a?.length)return null;let i=t.createVertexArray();t.bindVertexArray(i);let o=L(t,3,new Float32Array(r.length),3,t.FLOAT),c=t.createBuffer(),u=[L(t,0,r,3,t.FLOAT),L(t,1,n,3,t.FLOAT),L(t,2,s,1,t.UNSIGNED_SHORT,{integer:!0}),o,c];t.bindBuffer(t.ELEMENT_ARRAY_BUFFER,c),t.bufferData(t.ELEMENT_ARRAY_BUFFER,a,t.DYNAMIC_DRAW),t.bindVertexArray(null);let h=a.length/3,l=new Float32Array(3*h);for(let d=0;d<h;d++)for(let m=0;m<3;m++)l[3*d+m]=(r[3*a[3*d]+m]+r[3*a[3*d+1]+m]+r[3*a[3*d+2]+m])/3;let f=Ne(t,e.panes.map(d=>[[...d.depth,0]]),1);return{array:i,light:o,order:c,buffers:u,count:h,centres:l,index:a,table:f,sortedFrom:null}}function dr(t,[e,r,n]){let s=[e,r,n].map(o=>Math.ceil(o/2)),a=new Float32Array(3*s[0]*s[1]*s[2]),i=0;for(let o=0;o<s[2];o++)for(let c=0;c<s[1];c++)for(let u=0;u<s[0];u++){let h=[0,0,0],l=0;for(let f=0;f<8;f++){let[d,m,v]=[2*o+(f>>2),2*c+(f>>1&1),2*u+(f&1)];if(d>=n||m>=r||v>=e)continue;l++;let p=3*((d*r+m)*e+v);for(let E=0;E<3;E++)h[E]+=t[p+E]}for(let f=0;f<3;f++)a[i++]=h[f]/l}return{values:a,dims:s}}function mr(t,e,r){let n=e.volume;if(!n)return null;let s=()=>{let l=t.createTexture();return t.bindTexture(t.TEXTURE_3D,l),oe(t,t.TEXTURE_3D,t.LINEAR,t.LINEAR,t.CLAMP_TO_EDGE),l},a=(l,f,d,m)=>{let v={values:f,dims:d};for(;Math.max(...v.dims)>r;)v=dr(v.values,v.dims);let p=m===1?v.values:v.values.map(E=>E/m);t.bindTexture(t.TEXTURE_3D,l),t.pixelStorei(t.UNPACK_ALIGNMENT,1),t.texImage3D(t.TEXTURE_3D,0,t.RGB16F,...v.dims,0,t.RGB,t.HALF_FLOAT,ie(p))},i=[n.dims[2],n.dims[1],n.dims[0]],o=l=>{let f=s(),d=e.arrays[l];return d?a(f,Float32Array.from(d,m=>O[m]*n[`${l}Scale`]),i,1):a(f,Float32Array.from(n[l]),[1,1,1],1),f},[c,u]=["extinction","albedo"].map(o),h=n.dims.map((l,f)=>(n.max[f]-n.min[f])/l);return{extinction:c,albedo:u,radiosity:s(),fill:a,dims:i,cell:Math.min(...h),min:n.min,max:n.max,unit:1}}var J=class t{static async load(e,r,n,s){let a=new t;return a.gl=e,a.data=r,a.textures=await cr(e,r,n),a.white=G(e,e.RGBA8,e.RGBA,e.UNSIGNED_BYTE,1,1,new Uint8Array([255,255,255,255])),a.mesh=lr(e,r),a.panes=fr(e,r),a.volume=mr(e,r,Math.min(e.getParameter(e.MAX_3D_TEXTURE_SIZE),s?96:256)),a.suns=new le(e,r,a,s),a}free(){let{gl:e}=this;for(let i of[this.mesh,this.panes].filter(Boolean))e.deleteVertexArray(i.array),i.buffers.forEach(o=>e.deleteBuffer(o));this.suns.free();let{extinction:r,albedo:n,radiosity:s}=this.volume??{};[...this.textures,this.white,this.surfaces,this.panes?.table,r,n,s].forEach(i=>i&&e.deleteTexture(i))}relight(e,r="total"){let{gl:n,data:s}=this,a=r==="error";this.values=a?Float32Array.from(s.arrays.error,o=>O[o]*s.mesh.errorScale):ce(s,r==="total"?["indirect","direct"]:[r],e,s.arrays.position.length),n.bindBuffer(n.ARRAY_BUFFER,this.mesh.light),n.bufferData(n.ARRAY_BUFFER,this.values,n.DYNAMIC_DRAW),this.surfaces&&n.deleteTexture(this.surfaces);let i=ht(s,e);if(this.surfaces=Ne(n,s.surfaces.map((o,c)=>[[...o.reflectance,o.both?1:0],[...i[c],0]]),2),this.panes&&(n.bindBuffer(n.ARRAY_BUFFER,this.panes.light),n.bufferData(n.ARRAY_BUFFER,ce(s,["pane"],e,s.arrays.panePosition.length),n.DYNAMIC_DRAW)),this.volume){let o=this.volume,c=ce(s,["volume"],e,3*o.dims[0]*o.dims[1]*o.dims[2]),u=(s.suns??[]).reduce((h,l)=>Math.max(h,...l.irradiance.map(f=>f*e[l.group]/4)),0);o.unit=Math.max(c.reduce((h,l)=>Math.max(h,l),u)/1e3,1e-30),o.fill(o.radiosity,c,o.dims,o.unit)}}sortPanes(e){let r=this.panes;if(!r||r.count>ir||r.sortedFrom&&r.sortedFrom.every((i,o)=>i===e[o]))return;r.sortedFrom=[...e];let n=new Float32Array(r.count);for(let i=0;i<r.count;i++)n[i]=(r.centres[3*i]-e[0])**2+(r.centres[3*i+1]-e[1])**2+(r.centres[3*i+2]-e[2])**2;let s=Uint32Array.from(n.keys()).sort((i,o)=>n[o]-n[i]),a=new Uint32Array(3*r.count);s.forEach((i,o)=>a.set(r.index.subarray(3*i,3*i+3),3*o)),this.gl.bindVertexArray(r.array),this.gl.bindBuffer(this.gl.ELEMENT_ARRAY_BUFFER,r.order),this.gl.bufferData(this.gl.ELEMENT_ARRAY_BUFFER,a,this.gl.DYNAMIC_DRAW),this.gl.bindVertexArray(null)}};var Q=[.2126,.7152,.0722];function pr(t){return t<=.0031308?12.92*t:t>=1?1:1.055*t**(1/2.4)-.055}function gt(t){let e=[];for(let o=0;o<t.length;o+=4){let c=Q[0]*t[o]+Q[1]*t[o+1]+Q[2]*t[o+2];c>0&&Number.isFinite(c)&&e.push(c)}if(!e.length)return 1;e.sort((o,c)=>o-c);let r=o=>Math.floor((e.length-1)*o),n=e.slice(r(.02),r(.98)+1),s=Math.exp(n.reduce((o,c)=>o+Math.log(c),0)/n.length),a=e[r(.9)],i=Math.min(Math.max(.18/s,.18/a),1.6/a);return Number.isFinite(i)&&i>0?i:1}function vr([t,e,r]){let n=(t+.3963377774*e+.2158037573*r)**3,s=(t-.1055613458*e-.0638541728*r)**3,a=(t-.0894841775*e-1.291485548*r)**3;return[4.0767416621*n-3.3077115913*s+.2309699292*a,-1.2684380046*n+2.6097574011*s-.3413193965*a,-.0041960863*n-.7034186147*s+1.707614701*a]}var xr=[[.24,.1,300],[.36,.13,285],[.48,.1,252],[.58,.09,210],[.68,.115,165],[.78,.15,140],[.87,.17,118],[.95,.13,104]],ee=xr.map(([t,e,r])=>[t,e*Math.cos(r*Math.PI/180),e*Math.sin(r*Math.PI/180)]),Er=(t,e)=>Math.hypot(t[0]-e[0],t[1]-e[1],t[2]-e[2]),j=ee.reduce((t,e,r)=>[...t,r?t[r-1]+Er(ee[r-1],e):0],[]);function br(t){let e=Math.min(Math.max(t,0),1)*j[j.length-1],r=1;for(;r<j.length-1&&j[r]<e;)r++;let n=(e-j[r-1])/(j[r]-j[r-1]);return[0,1,2].map(s=>ee[r-1][s]+n*(ee[r][s]-ee[r-1][s]))}function Le(t){return vr(br(t)).map(e=>Math.min(Math.max(e,0),1))}function Be(t){return`rgb(${Le(t).map(e=>Math.round(255*pr(e))).join(" ")})`}var yt=.995,Tt=t=>({eye:[...t.eye],forward:[...t.forward],up:[...t.up],fov:t.fov}),fe=t=>({eye:[...t.origin],forward:A(N(t.target,t.origin)),up:A(t.up),fov:t.fov});function Ce(t,e){let r=P(t[0],t[1],.5),n=A([-1,-1.4,-.8]),s={eye:r,forward:n,up:[0,0,1],fov:50},{tanX:a,tanY:i}=C(s,e),o=.5*H(N(t[1],t[0]));return{...s,eye:N(r,y(n,.95*o/Math.sin(Math.atan(Math.min(a,i)))))}}function Oe(t,e,r){let n=W(t.forward,t.up,e),s=A(S(n,t.up)),a=A(W(n,s,r)),i=Math.abs(_(a,t.up));return(i<yt||i<Math.abs(_(n,t.up)))&&(n=a),{...t,forward:A(n)}}function wt(t,e,r,n){let s=A(S(t.forward,t.up)),a=A(S(t.up,s));return{...t,eye:w(t.eye,w(w(y(a,e),y(s,r)),y(t.up,n)))}}function Ie(t,e,r,n){let s=A(S(t.forward,t.up)),a=_(W(t.forward,s,n),t.up),i=Math.abs(a)<yt||Math.abs(a)<Math.abs(_(t.forward,t.up))?n:0,o=c=>W(W(c,s,i),t.up,r);return{...t,eye:w(e,o(N(t.eye,e))),forward:A(o(t.forward))}}function ze(t,e,r){return{...t,eye:w(e,y(N(t.eye,e),r))}}function At(t,e,r,n,s,a){let i=Math.max(_(N(e,t.eye),t.forward),1e-6),o=A(S(t.forward,t.up)),c=S(o,t.forward),u=w(y(o,-2*r*s*i),y(c,2*n*a*i));return{camera:{...t,eye:w(t.eye,u)},pivot:w(e,u)}}function Rt(t,e,r){let n=r*r*(3-2*r);return{eye:P(t.eye,e.eye,n),forward:A(P(t.forward,e.forward,n)),up:A(P(t.up,e.up,n)),fov:t.fov+(e.fov-t.fov)*n}}var de=t=>String(Number(t.toPrecision(9))+0),$e=t=>t.map(de).join(", ");function Mt({origin:t,target:e,up:r,fov:n}){return`# zonal render RUN.npz --camera-file camera.toml -o picture.png
[[camera]]
name = "view"
origin = [${$e(t)}]
target = [${$e(e)}]
up = [${$e(r)}]
fov = ${de(n)}
`}function _t({origin:t,target:e,up:r,fov:n}){let s=i=>i.map(de).join(","),a=r[0]===0&&r[1]===0&&r[2]>0;return`--from ${s(t)} --look-at ${s(e)} --fov ${de(n)}${a?"":` --up ${s(r)}`}`}function Ft(t,e){let r=URL.createObjectURL(new Blob([e],{type:"text/plain"}));Object.assign(document.createElement("a"),{href:r,download:t}).click(),setTimeout(()=>URL.revokeObjectURL(r),1e4)}async function St(t){try{return await navigator.clipboard.writeText(t),!0}catch{return!1}}var He={KeyW:["ahead",1],ArrowUp:["ahead",1],KeyS:["ahead",-1],ArrowDown:["ahead",-1],KeyA:["right",-1],KeyD:["right",1],KeyE:["up",1],KeyQ:["up",-1],ArrowLeft:["yaw",1],ArrowRight:["yaw",-1],PageUp:["pitch",1],PageDown:["pitch",-1]},yr=t=>t.target.closest?.("input, select, textarea, button"),me=class{constructor(e,r){this.canvas=e,this.on=r,this.held=new Set,this.fast=!1,this.pointers=new Map,e.addEventListener("pointerdown",n=>this.down(n)),e.addEventListener("pointermove",n=>this.move(n));for(let n of["pointerup","pointercancel"])e.addEventListener(n,s=>this.up(s));e.addEventListener("wheel",n=>this.wheel(n),{passive:!1}),e.addEventListener("contextmenu",n=>n.preventDefault()),addEventListener("keydown",n=>this.keydown(n)),addEventListener("keyup",n=>{this.held.delete(n.code),this.fast=n.shiftKey}),addEventListener("blur",()=>this.held.clear())}keydown(e){this.fast=e.shiftKey,!e.target.closest?.("dialog")&&(e.ctrlKey||e.metaKey||e.altKey||yr(e)&&e.key!=="Escape"||(He[e.code]?(e.preventDefault(),this.held.add(e.code),this.on.changed()):this.on.key(e.code,e)&&e.preventDefault()))}motion(){let e={ahead:0,right:0,up:0,yaw:0,pitch:0};for(let r of this.held)e[He[r][0]]+=He[r][1];return e}get active(){return this.held.size>0}at(e){let r=this.canvas.getBoundingClientRect();return[(e.clientX-r.left)/r.width,(e.clientY-r.top)/r.height]}down(e){this.canvas.focus({preventScroll:!0}),this.canvas.setPointerCapture(e.pointerId),this.pointers.set(e.pointerId,{at:this.at(e),start:this.at(e),second:e.button===2||e.button===1||e.shiftKey}),this.moved=this.pointers.size>1}move(e){let r=this.pointers.get(e.pointerId);if(!r)return;let n=[...this.pointers.values()].map(i=>i.at),s=r.at;if(r.at=this.at(e),Math.hypot((r.at[0]-r.start[0])*this.canvas.clientWidth,(r.at[1]-r.start[1])*this.canvas.clientHeight)>5&&(this.moved=!0),!!this.moved){if(this.pointers.size===1)(r.second?this.on.pan:this.on.look)(r.at[0]-s[0],r.at[1]-s[1]);else if(this.pointers.size===2){let i=[...this.pointers.values()].map(u=>u.at),o=([u,h])=>Math.hypot((u[0]-h[0])*this.canvas.clientWidth,(u[1]-h[1])*this.canvas.clientHeight),c=([u,h],l)=>(u[l]+h[l])/2;this.on.pan(c(i,0)-c(n,0),c(i,1)-c(n,1)),this.on.zoom(o(n)/Math.max(o(i),1))}this.on.changed()}}up(e){let r=this.pointers.get(e.pointerId);this.pointers.delete(e.pointerId),r&&!this.moved&&e.type==="pointerup"&&e.button===0&&this.on.tap(...r.at),this.on.changed()}wheel(e){e.preventDefault();let r=e.deltaMode===1?16:1;this.on.zoom(Math.exp(Math.min(Math.max(e.deltaY*r,-120),120)*.0015)),this.on.changed()}};function V(t,e=4){if(!Number.isFinite(t))return"–";if(t===0)return"0";let r=Math.abs(t);if(r>=1e5||r<.001){let[n,s]=t.toExponential(e-1).split("e");return`${n}e${Number(s)}`}return t.toFixed(Math.max(0,e-1-Math.floor(Math.log10(r))))}var Nt=t=>t.toFixed(Math.abs(t)<1e3?3:1),Z=t=>String(t).replace(/\B(?=(\d{3})+$)/g," "),Xe=t=>`${t===0?"0":t<1e-5?"< 0.001":(100*t).toPrecision(2).replace(/\.0+$/,"")} %`,kt=t=>t.some(e=>!Number.isFinite(e))?"unknown":Xe(Math.max(...t));var Ge=t=>t===0?"off":`× ${t>=100?t.toFixed(0):t.toPrecision(t>=1?3:2).replace(/\.?0+$/,"")}`,Pt=t=>`${t>0?"+":t<0?"−":""}${Math.abs(t).toFixed(1)} EV`,q=-8,je=t=>t<=2**(q+.05)?q:Math.min(Math.log2(t),-q),qe=t=>t<=q+1e-9?0:2**t;function Dt(t,e,r){if(!(e>t))return[t];let n=[];if(r&&t>0){let o=Math.log10(e/t),c=o>4?[1]:o>1.5?[1,3]:[1,2,5];for(let u=Math.floor(Math.log10(t));u<=Math.ceil(Math.log10(e));u++)n.push(...c.map(h=>h*10**u).filter(h=>h>=t*.999&&h<=e*1.001));return n}let s=(e-t)/5,a=10**Math.floor(Math.log10(s)),i=[1,2,5,10].map(o=>o*a).find(o=>o>=s);for(let o=Math.ceil(t/i-1e-6)||0;o*i<=e*(1+1e-9)+1e-12;o++)n.push(o*i);return n}var Tr=[["R","#e0726a"],["G","#7fc27a"],["B","#6f9be8"]],M=(t,e="",r="")=>Object.assign(document.createElement(t),{textContent:e,className:r});function I(t,e,r=!1,n=V){let s=M("tr"),a=M("th",t,r?"sub":"");return a.scope="row",s.append(a,...e.map(i=>M("td",n(i)))),s}function Ve(t){let e=M("tr","","group"),r=M("th",t);return r.colSpan=4,e.append(r),e}function Ut(t,e,r){let n=M("header"),s=M("button","×","icon small");s.type="button",s.setAttribute("aria-label","Close the probe"),s.addEventListener("click",r),n.append(M("strong",e.surface),s);let a=M("div",`zone ${Z(e.zone)} · ${e.position.map(Nt).join(", ")} m`,"where"),i=M("table"),o=M("thead"),c=M("tr"),u=M("th","W/m²");u.scope="col",c.append(u,...Tr.map(([f,d])=>{let m=M("th","");m.scope="col";let v=M("i");return v.style.background=d,m.append(v,f),m})),o.append(c);let h=M("tbody");e.here.radiosity?h.append(Ve("at this point"),I("Radiosity",e.here.radiosity)):h.append(Ve("at this point")),h.append(I("Irradiance",e.here.irradiance),I("indirect",e.here.indirect,!0),I("direct",e.here.direct,!0));let l=e.mean;h.append(Ve("mean of the zone"),I("Radiosity",l.radiosity),I("Irradiance",l.irradiance),I("indirect",l.indirect,!0),I("direct",l.direct,!0),I("error",l.error,!0,f=>Number.isFinite(f)?V(f):"unknown")),i.append(o,h),t.replaceChildren(n,a,i),t.append(M("div","error: estimate for the irradiance, as solved","note")),e.through.length&&t.append(M("div",`seen through ${e.through.join(", ")}`,"note")),e.back&&t.append(M("div","back of a one-sided surface; the numbers are those of its front","note")),t.hidden=!1}var x=t=>document.getElementById(t),wr=["sunlight","direct light"],pe={irradiance:"Irradiance",radiosity:"Radiosity",error:"Error estimate of the irradiance"},Ar={mean:"mean of bands",luminance:"luminance",red:"red band",green:"green band",blue:"blue band"};function Rr(t){let{min:e,max:r,value:n}=t,s=100*(n-e)/(r-e);t.style.setProperty("--from",`${Math.min(s,50)}%`),t.style.setProperty("--to",`${Math.max(s,50)}%`)}function Ye(t,e,r,n,s){t.value=r,t.setAttribute("aria-valuetext",n),e.textContent=n,e.classList.toggle("changed",s),Rr(t)}var ve=class{constructor(e,r){this.data=e,this.on=r,x("title").textContent=e.name,document.title=`${e.name} · zonal`,this.cameras(e.cameras),this.lights(e.groups),this.report(e),x("densityRow").hidden=!e.volume,x("exposure").addEventListener("input",n=>r.stops(Number(n.target.value))),x("density").addEventListener("input",n=>r.density(qe(Number(n.target.value))));for(let[n,s]of[["exposure",()=>r.stops(0)],["density",()=>r.density(1)]])x(n).addEventListener("dblclick",s);x("saveCamera").addEventListener("click",()=>r.saveCamera()),x("copyCamera").addEventListener("click",()=>r.copyCamera()),x("lightsReset").addEventListener("click",()=>r.lightsReset()),x("show").addEventListener("change",n=>r.show(n.target.value)),x("band").addEventListener("change",n=>r.band(n.target.value)),x("part").addEventListener("change",n=>r.part(n.target.value)),x("log").addEventListener("click",()=>r.log(!0)),x("linear").addEventListener("click",()=>r.log(!1)),x("rangeReset").addEventListener("click",()=>r.range(null));for(let n of["low","high"])x(n).addEventListener("change",()=>this.readRange());for(let n of["walk","orbit"])x(n).addEventListener("click",()=>r.mode(n));x("panelButton").addEventListener("click",()=>this.toggle()),x("helpButton").addEventListener("click",()=>x("help").showModal())}cameras(e){let r=x("camera"),n=(s,a)=>r.append(Object.assign(document.createElement("option"),{textContent:s,value:a}));e.forEach((s,a)=>n(s.name,a)),n("overview","overview"),n("free","free"),r.addEventListener("change",()=>r.value!=="free"&&this.on.camera(r.value==="overview"?"overview":Number(r.value)))}lights(e){e.forEach((r,n)=>{let s=document.createElement("div");s.className="slider light";let a=`light${n}`,i=Object.assign(document.createElement("label"),{htmlFor:a,textContent:r.name,title:r.name}),o=Object.assign(document.createElement("output"),{id:`${a}Out`,htmlFor:a}),c=Object.assign(document.createElement("input"),{type:"range",id:a,min:q,max:-q,step:.1});c.addEventListener("input",()=>this.on.light(n,qe(Number(c.value)))),c.addEventListener("dblclick",()=>this.on.light(n,1)),s.append(i,o,c),x("lights").append(s)})}report({counts:e,report:r}){for(let a of["report","warnings"])x(a).replaceChildren();let n=(a,i)=>{x("report").append(Object.assign(document.createElement("dt"),{textContent:a}),Object.assign(document.createElement("dd"),{textContent:i}))};n("Patches",Z(e.patches)),e.voxels&&n("Volume zones",Z(e.voxels)),e.panes&&n("Pane zones",Z(e.panes)),n("Engine",r.engine),n("Solver status",r.status);let s=a=>r.estimates.map(i=>kt(i[a])).join(" → ");n("RMS error of H",s("patches")),(e.voxels||e.panes)&&n("RMS error of G",s("volumes")),n("Grade of factors",r.grade),wr.includes(r.stage)||n("Energy residual",Xe(Math.max(...r.residual.map(Math.abs))));for(let{severity:a,text:i,advice:o}of r.notes){let c=Object.assign(document.createElement("li"),{className:a,textContent:i});o&&c.append(Object.assign(document.createElement("p"),{textContent:o})),x("warnings").append(c)}}readRange(){let[e,r]=["low","high"].map(s=>Number(x(s).value.replace(",","."))),n=Number.isFinite(e)&&Number.isFinite(r)&&r>e&&e>=0;for(let s of["low","high"])x(s).setAttribute("aria-invalid",String(!n));n&&this.on.range([e,r])}showCopied(e){x("copied").textContent=e,x("copied").hidden=!1}toggle(e=x("panel").hidden){x("panel").hidden=!e,document.body.classList.toggle("panel",e),x("panelButton").setAttribute("aria-expanded",String(e))}update(e,r){Ye(x("exposure"),x("exposureOut"),e.stops,Pt(e.stops),e.stops!==0),Ye(x("density"),x("densityOut"),je(e.density),Ge(e.density),e.density!==1),e.factors.forEach((s,a)=>Ye(x(`light${a}`),x(`light${a}Out`),je(s),Ge(s),s!==1)),x("lightsReset").disabled=e.factors.every(s=>s===1);for(let s of document.getElementsByName("show"))s.checked=s.value===e.show;let n=e.show!=="picture";x("mapSettings").hidden=!n,x("pictureSettings").hidden=n,x("band").value=e.band,x("part").value=e.part,x("partRow").hidden=e.show==="error",x("log").setAttribute("aria-pressed",String(e.log)),x("linear").setAttribute("aria-pressed",String(!e.log));for(let s of["walk","orbit"])x(s).setAttribute("aria-pressed",String(e.mode===s));x("camera").value=e.activeCamera??"free",n&&this.legend(e,r),x("legend").hidden=!n,document.body.classList.toggle("mapped",n)}legend(e,[r,n]){document.activeElement!==x("low")&&(x("low").value=V(r,3)),document.activeElement!==x("high")&&(x("high").value=V(n,3));let s=e.part==="total"||e.show==="error"?pe[e.show]:`${pe[e.show]} of ${e.part} light`;x("legendTitle").replaceChildren(s,Object.assign(document.createElement("span"),{textContent:` · ${Ar[e.band]} · W/m²`})),x("legendBar").style.background=`linear-gradient(90deg in srgb, ${Array.from({length:33},(c,u)=>Be(u/32)).join(", ")})`,x("legendBar").style.background||(x("legendBar").style.background=`linear-gradient(90deg, ${Array.from({length:33},(c,u)=>Be(u/32)).join(", ")})`);let a=c=>e.log?Math.log(c/r)/Math.log(n/r):(c-r)/(n-r),i=-1,o=Dt(r,n,e.log).filter(c=>{let u=a(c)-i>.11;return u&&(i=a(c)),u});x("legendTicks").replaceChildren(...o.map(c=>{let u=Object.assign(document.createElement("span"),{textContent:V(c,3).replace(/(\.\d*?)0+$/,"$1").replace(/\.$/,"")});return u.style.left=`${100*a(c)}%`,u}))}};function te(t,e,r,n=!1){let{position:s,index:a,surface:i}=t.arrays,o=t.surfaces.map(d=>d.both),[c,u,h]=r,l=null,f=1/0;for(let d=0;d<a.length;d+=3){let m=3*a[d],v=3*a[d+1],p=3*a[d+2],E=s[v]-s[m],b=s[v+1]-s[m+1],g=s[v+2]-s[m+2],T=s[p]-s[m],F=s[p+1]-s[m+1],R=s[p+2]-s[m+2],U=u*R-h*F,$=h*T-c*R,ne=c*F-u*T,K=E*U+b*$+g*ne;if(K===0||K<0&&(n||o[i[a[d]]]))continue;let ye=e[0]-s[m],Te=e[1]-s[m+1],we=e[2]-s[m+2],se=(ye*U+Te*$+we*ne)/K;if(se<0||se>1)continue;let Ze=Te*g-we*b,Je=we*E-ye*g,Qe=ye*b-Te*E,Ae=(c*Ze+u*Je+h*Qe)/K;if(Ae<0||se+Ae>1)continue;let ae=(T*Ze+F*Je+R*Qe)/K;ae>0&&ae<f&&(f=ae,l={triangle:d/3,t:ae,u:se,v:Ae,back:K<0})}return l}function Mr(t,e,r,n){let{panePosition:s,paneIndex:a,paneOf:i}=t.arrays;if(!a)return[];let o=new Map,c={arrays:{position:s,index:null,surface:i},surfaces:t.panes.map(()=>({both:!1}))};for(let u=0;u<a.length;u+=3){c.arrays.index=a.subarray(u,u+3);let h=te(c,e,r);h&&h.t<n&&o.set(i[a[u]],Math.min(h.t,o.get(i[a[u]])??1/0))}return[...o].sort((u,h)=>u[1]-h[1]).map(([u])=>t.panes[u].name)}function Lt(t,e,r,n,s){let a=te(t,r,n,s);if(!a)return null;let{index:i,triangleZone:o,surface:c,error:u}=t.arrays,h=[0,1,2].map(p=>i[3*a.triangle+p]),l=[1-a.u-a.v,a.u,a.v],f=(p,E)=>[0,1,2].map(b=>h.reduce((g,T,F)=>g+l[F]*E*O[p[3*T+b]],0)),d=p=>t.groups.reduce((E,b,g)=>{let T=t.arrays[p+g],F=T?f(T,e[g]*b.scales[p]):[0,0,0];return E.map((R,U)=>R+F[U])},[0,0,0]),m=o[a.triangle],v=r.map((p,E)=>p+a.t*n[E]);return{point:v,position:v.map((p,E)=>p+t.origin[E]),distance:a.t,back:a.back,surface:t.surfaces[c[h[0]]].name,zone:m,through:Mr(t,r,n,a.t),here:{indirect:d("indirect"),direct:d("direct"),error:f(u,t.mesh.errorScale)},mean:ue(t,m,e)}}var X=`#version 300 es
precision highp float;
precision highp int;
`,Ke=`
float noise(vec2 p) { return fract(52.9829189 * fract(0.06711056 * p.x + 0.00583715 * p.y)); }
float linearDepth(float z, vec2 planes) {
return 2.0 * planes.x * planes.y / (planes.y + planes.x - (2.0 * z - 1.0) * (planes.y - planes.x));
}`,Bt=t=>({vertex:`${X}
layout(location = 0) in vec3 position;
layout(location = 1) in vec2 uv;
layout(location = 2) in uint surface;
layout(location = 3) in vec3 irradiance;
layout(location = 4) in vec3 normal;
// On a curved surface its unit normal, and the height of the surface above the facet, m; zero on a flat one.
layout(location = 5) in vec4 curve;
uniform mat4 viewProjection;
uniform vec3 eye;
uniform bool cracks;
// Centroid interpolation: extrapolation beyond a triangle would be too bright or negative where the light is steep.
centroid out vec2 vUv;
centroid out vec3 vH;
centroid out vec3 vPoint;
centroid out vec4 vCurve;
flat out vec3 vNormal;
flat out int vSurface;
flat out int vAway;
void main() {
vAway = cracks && dot(normal, eye - position) <= 0.0 ? 1 : 0;
vUv = uv;
vH = irradiance;
vPoint = position;
vNormal = normal;
vCurve = curve;
vSurface = int(surface);
gl_Position = viewProjection * vec4(position, 1.0);
// Crack lines lie slightly behind the surfaces whose gaps they close.
if (cracks) gl_Position.z += 1e-6 * gl_Position.w;
}`,fragment:`${X}${Ke}${De(t)}
centroid in vec2 vUv;
centroid in vec3 vH;
centroid in vec3 vPoint;
centroid in vec4 vCurve;
flat in vec3 vNormal;
flat in int vSurface;
flat in int vAway;
uniform highp sampler2D surfaces;
uniform sampler2D albedo, emission, colours;
uniform float exposure, emitted, baked;
uniform int show;
uniform bool hideBacks, cracks;
uniform float crackInset;
uniform vec4 range;
uniform vec3 weights;
out vec4 colour;
void main() {
ivec2 at = ivec2(vSurface & 511, 2 * (vSurface >> 9));
vec4 reflectance = texelFetch(surfaces, at, 0);
if (!gl_FrontFacing || vAway == 1) {
if (hideBacks || reflectance.a > 0.5 || vAway == 1) discard;
colour = vec4(0.0, 0.0, 0.0, 1.0);
return;
}
vec3 rho = min(reflectance.rgb * texture(albedo, vUv).rgb, 1.0);
vec3 n = normalize(vNormal);
float turn = noise(gl_FragCoord.xy);
vec3 lit = vPoint;
if (dot(vCurve.xyz, vCurve.xyz) > 0.1) {
// Sunlight falls on the curved surface for which the facet stands.
lit += vCurve.w * n;
n = normalize(vCurve.xyz);
}
vec3 sun = sunlight(lit, n, turn);
if (cracks && sun != vec3(0.0)) {
// A line along an edge is lit only where both sides are.
vec3 side = crackInset * normalize(cross(n, abs(n.z) < 0.9 ? vec3(0.0, 0.0, 1.0) : vec3(1.0, 0.0, 0.0)));
vec3 other = cross(n, side);
sun = min(min(sunlight(lit + side, n, turn), sunlight(lit - side, n, turn)), min(sunlight(lit + other, n, turn), sunlight(lit - other, n, turn)));
}
vec3 H = baked * vH + sun;
vec3 B = emitted * texelFetch(surfaces, at + ivec2(0, 1), 0).rgb * texture(emission, vUv).rgb + rho * H;
if (show == 0) {
colour = vec4(min(B * (exposure / 3.14159265359), 60000.0), 1.0);
return;
}
if (show == 3) {
colour = vec4(min(H * exposure, 60000.0), 1.0);
return;
}
float value = dot(weights, show == 1 ? B : H);
float t = range.z > 0.5 ? (log2(max(value, 1e-35)) - range.x) * range.y : (value - range.x) * range.y;
colour = vec4(texture(colours, vec2(clamp(t, 0.0, 1.0) * (255.0 / 256.0) + 0.5 / 256.0, 0.5)).rgb, 1.0);
}`}),xe={vertex:`${X}
layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;
layout(location = 2) in uint pane;
layout(location = 3) in vec3 radiosity;
uniform mat4 viewProjection;
out vec3 vPoint;
out vec3 vB;
flat out vec3 vNormal;
flat out int vPane;
void main() {
vPoint = position;
vB = radiosity;
vNormal = normal;
vPane = int(pane);
gl_Position = viewProjection * vec4(position, 1.0);
}`,fragment:`${X}
in vec3 vPoint;
in vec3 vB;
flat in vec3 vNormal;
flat in int vPane;
uniform highp sampler2D panes;
uniform vec3 eye;
uniform float exposure;
uniform int band;
out vec4 colour;
void main() {
float cosine = max(abs(dot(normalize(vPoint - eye), vNormal)), 1e-4);
vec3 passed = exp(-texelFetch(panes, ivec2(vPane & 511, vPane >> 9), 0).rgb / cosine);
vec3 added = min((1.0 - passed) * vB * (exposure / 3.14159265359), 60000.0);
colour = vec4(vec3(added[band]), passed[band]);
}`,tint:`${X}
in vec3 vPoint;
flat in vec3 vNormal;
flat in int vPane;
uniform highp sampler2D panes;
uniform highp sampler2D depth;
uniform vec3 eye, ahead;
uniform vec2 planes;
uniform vec2 size;
out vec4 colour;
void main() {
float z = texture(depth, gl_FragCoord.xy / size).r;
float seen = 2.0 * planes.x * planes.y / (planes.y + planes.x - (2.0 * z - 1.0) * (planes.y - planes.x));
vec3 ray = vPoint - eye;
if (dot(ray, ahead) > seen) discard;
float cosine = max(abs(dot(normalize(ray), vNormal)), 1e-4);
colour = vec4(exp(-texelFetch(panes, ivec2(vPane & 511, vPane >> 9), 0).rgb / cosine), length(ray));
}`},Ct=`${X}
out vec2 at;
void main() {
at = vec2(gl_VertexID & 1, gl_VertexID >> 1) * 2.0;
gl_Position = vec4(2.0 * at - 1.0, 0.0, 1.0);
}`,Ot=t=>({vertex:Ct,fragment:`${X}${Ke}${De(t)}
in vec2 at;
uniform highp sampler2D depth;
uniform sampler2D paneTint;
uniform highp sampler3D extinction, radiosity, albedo;
uniform vec3 eye, forward, across, upward, low, high;
uniform vec2 planes;
uniform float density, exposure, stride, shift;
uniform int maxSteps;
uniform bool hasPanes;
layout(location = 0) out vec4 scattered;
layout(location = 1) out vec4 transmittance;
void main() {
float z = linearDepth(texture(depth, at).r, planes);
vec3 ray = forward + (2.0 * at.x - 1.0) * across + (2.0 * at.y - 1.0) * upward;
float end = z * length(ray);
vec3 dir = normalize(ray);
vec3 one = (low - eye) / dir, two = (high - eye) / dir;
vec3 near = min(one, two), far = max(one, two);
float t0 = max(max(near.x, max(near.y, near.z)), 0.0);
float t1 = min(min(far.x, min(far.y, far.z)), end);
vec3 tau = vec3(1.0), sum = vec3(0.0);
vec4 glass = hasPanes ? texture(paneTint, at) : vec4(1.0, 1.0, 1.0, 1e30);
if (t1 > t0) {
int count = clamp(int(ceil((t1 - t0) / stride)), 1, maxSteps);
float step = (t1 - t0) / float(count);
float first = t0 + step * (shift < 0.0 ? 0.5 : fract(noise(gl_FragCoord.xy) + shift));
for (int i = 0; i < count; i++) {
float t = first + float(i) * step;
vec3 where = ((eye + dir * t - low) / (high - low)).zyx;
vec3 kappa = density * texture(extinction, where).rgb;
vec3 left = exp(-kappa * step);
vec3 B = texture(radiosity, where).rgb;
${t?`      vec2 random = fract(noise(gl_FragCoord.xy) + vec2(0.61803399, 0.75487767) * float(i));
B += 0.25 * texture(albedo, where).rgb * sunFluence(eye + dir * (t0 + (float(i) + random.x) * step), random.y, fract(7.0 * random.x));
`:""}      vec3 light = tau * (1.0 - left) * B;
sum += t > glass.a ? light * glass.rgb : light;
tau *= left;
}
}
scattered = vec4(min(sum * exposure, 60000.0), end);
transmittance = vec4(tau, 1.0);
}`}),It={vertex:Ct,fragment:`${X}${Ke}
in vec2 at;
uniform sampler2D image;
uniform highp sampler2D depth;
uniform highp sampler2D scattered;
uniform sampler2D transmittance;
uniform vec3 forward, across, upward;
uniform vec2 planes;
uniform bool hasMedium;
uniform int finish;
out vec4 colour;
vec2 range(vec3 c) {
return vec2(min(c.r, min(c.g, c.b)), max(c.r, max(c.g, c.b)));
}
vec3 curve(vec3 x) {
x = max(x, 0.0);
vec3 t = (x - 0.25) / 0.75;
vec3 y = mix(x, 0.25 + 0.75 * t / (1.0 + t), greaterThan(x, vec3(0.25)));
// Mean of the per-band curve and the curve that preserves the hue.
vec2 from = range(x), to = range(y);
return 0.5 * (y + to.x + (x - from.x) * (to.y - to.x) / max(from.y - from.x, 1e-12));
}
vec3 srgb(vec3 x) {
x = clamp(x, 0.0, 1.0);
return mix(1.055 * pow(x, vec3(1.0 / 2.4)) - 0.055, 12.92 * x, lessThanEqual(x, vec3(0.0031308)));
}
void main() {
vec3 L = texture(image, at).rgb;
if (hasMedium) {
// Bilateral upsampling: the four nearest samples, weighted by the difference of their distance.
vec3 ray = forward + (2.0 * at.x - 1.0) * across + (2.0 * at.y - 1.0) * upward;
float far = linearDepth(texture(depth, at).r, planes) * length(ray);
ivec2 size = textureSize(scattered, 0);
vec2 p = at * vec2(size) - 0.5;
ivec2 base = ivec2(floor(p));
vec2 f = p - vec2(base);
vec3 s = vec3(0.0), t = vec3(0.0);
float total = 0.0;
for (int k = 0; k < 4; k++) {
ivec2 o = ivec2(k & 1, k >> 1);
ivec2 q = clamp(base + o, ivec2(0), size - 1);
vec4 a = texelFetch(scattered, q, 0);
float w = (o.x == 1 ? f.x : 1.0 - f.x) * (o.y == 1 ? f.y : 1.0 - f.y) + 1e-3;
w /= 1e-3 + abs(min(a.a, 6e4) - min(far, 6e4)) / min(far, 6e4);
s += w * a.rgb;
t += w * texelFetch(transmittance, q, 0).rgb;
total += w;
}
L = L * (t / total) + s / total;
}
if (finish == 2) {
colour = vec4(L, 1.0);
return;
}
vec3 v = srgb(finish == 1 ? L : curve(L));
vec2 p = vec2(gl_FragCoord.x, gl_FragCoord.y);
vec3 d = vec3(noise(p), noise(p + vec2(47.0, 17.0)), noise(p + vec2(94.0, 34.0)));
colour = vec4(v + (d - 0.5) / 255.0, 1.0);
}`};var We={mean:[1/3,1/3,1/3],luminance:Q,red:[1,0,0],green:[0,1,0],blue:[0,0,1]},_r=13,Fr=32,Sr=42,zt=38,Nr={picture:0,map:1,linear:2},Ee=class{constructor(e,r){this.gl=e,this.programs={pane:B(e,xe),tint:B(e,{vertex:xe.vertex,fragment:xe.tint}),final:B(e,It)},this.counts={calls:0,bytes:0};let n=new Float32Array(4*256);for(let s=0;s<256;s++)n.set([...Le(s/255),1],4*s);this.colours=G(e,e.RGBA16F,e.RGBA,e.FLOAT,256,1,n,e.LINEAR),this.samples=Math.min(4,e.getParameter(e.MAX_SAMPLES)),this.screen=e.createVertexArray(),this.cached=null,this.show(r)}show(e){let{gl:r,programs:n}=this;if(this.scene?.suns.count!==e.suns.count){for(let a of["mesh","medium"])n[a]?.free();Object.assign(n,{mesh:B(r,Bt(e.suns.count)),medium:B(r,Ot(e.suns.count))})}this.scene=e;let{bounds:s}=e.data;this.diagonal=Math.hypot(...s[1].map((a,i)=>a-s[0][i]))}targets(e,r,n){let s=`${e} ${r} ${n}`;return this.cached?.key!==s&&(this.cached?.targets.free(),this.cached={key:s,targets:ot(this.gl,e,r,n,this.samples,!!this.scene.volume)}),this.cached.targets}view(e,r){let n=C(e,r),{bounds:s}=this.scene.data,a=Math.hypot(...[0,1,2].map(c=>Math.max(s[0][c]-e.eye[c],0,e.eye[c]-s[1][c]))),i=Math.max(4e-4*this.diagonal,.2*a),o=1.1*this.diagonal+a+i;return{...n,near:i,far:o,matrix:it(e.eye,n,i,o),lens:{forward:n.forward,across:y(n.right,n.tanX),upward:y(n.up,n.tanY),planes:[i,o]}}}draw(e,r,n,s,a=null,i="picture"){let{gl:o,scene:c}=this,u=e.show==="picture";c.suns.prepare(),this.counts={calls:0,bytes:0};let h=this.targets(r,n,s.mediumScale),l=this.view(e.camera,r/n);o.bindFramebuffer(o.FRAMEBUFFER,h.multisampled),o.viewport(0,0,r,n),o.enable(o.DEPTH_TEST),o.depthMask(!0);let f=u?lt(c.data,e.factors).map(m=>Math.min(m*e.exposure,6e4)):[.0045,.005,.006];o.clearColor(...f,1),o.clear(o.COLOR_BUFFER_BIT|o.DEPTH_BUFFER_BIT),this.drawMesh(e,l,s,i),u&&c.panes&&!e.withoutPanes&&this.drawPanes(e,l),o.disable(o.DEPTH_TEST),h.multisampled!==h.resolved&&(o.bindFramebuffer(o.READ_FRAMEBUFFER,h.multisampled),o.bindFramebuffer(o.DRAW_FRAMEBUFFER,h.resolved),o.blitFramebuffer(0,0,r,n,0,0,r,n,o.COLOR_BUFFER_BIT|o.DEPTH_BUFFER_BIT,o.NEAREST));let d=u&&h.medium&&e.density>0;d&&this.drawMedium(e,l,h,s),o.bindFramebuffer(o.FRAMEBUFFER,a),o.viewport(0,0,r,n),this.programs.final.use({image:[0,o.TEXTURE_2D,h.image],depth:[1,o.TEXTURE_2D,h.depth],hasMedium:d,scattered:[2,o.TEXTURE_2D,d?h.medium.scattered:h.image],transmittance:[3,o.TEXTURE_2D,d?h.medium.transmittance:h.image],...l.lens,finish:Nr[i==="linear"?"linear":u?"picture":"map"]}),this.drawScreen()}drawScreen(){let{gl:e}=this;e.bindVertexArray(this.screen),e.drawArrays(e.TRIANGLES,0,3),e.bindVertexArray(null),this.counts.calls++}drawElements(e,r,n,s){this.gl.drawElements(e,r,this.gl.UNSIGNED_INT,n),this.counts.calls++,this.counts.bytes+=r*(4+s)}sunUniforms(e,r,n){let s=e.show!=="error"&&e.part!=="indirect";return this.scene.suns.uniforms(e.factors,s?n:0,r.sunSamples??Fr)}drawMesh(e,r,n,s){let{gl:a,scene:i}=this,{show:o}=e,c=o==="picture"?"total":e.part??"total",u=this.programs.mesh,[h,l]=e.range??[0,1],f=!!e.log,d=f?[Math.log2(h),Math.log2(l)]:[h,l];u.use({viewProjection:r.matrix,eye:e.camera.eye,exposure:e.exposure,surfaces:[0,a.TEXTURE_2D,i.surfaces],colours:[3,a.TEXTURE_2D,this.colours],hideBacks:!!e.hideBacks,show:o==="picture"?0:o==="radiosity"?1:s==="linear"?3:2,emitted:c==="total"?1:0,baked:c==="sun"?0:1,...this.sunUniforms({...e,part:c},n,1),range:[d[0],1/(d[1]-d[0]||1),f?1:0,0],weights:We[e.band??"mean"]}),a.bindVertexArray(i.mesh.array);for(let[m,v,p]of[[a.TRIANGLES,i.mesh.triangles,!1],[a.LINES,i.mesh.cracks,!0]]){a.bindBuffer(a.ELEMENT_ARRAY_BUFFER,v.buffer),u.set("cracks",p);for(let E of v.runs)u.set("albedo",[1,a.TEXTURE_2D,i.textures[E.texture]??i.white]),u.set("emission",[2,a.TEXTURE_2D,i.textures[E.emissionTexture]??i.white]),this.drawElements(m,E.count,4*E.first,Sr)}a.bindVertexArray(null)}drawPanes(e,r){let{gl:n,scene:s}=this;s.sortPanes(e.camera.eye),this.programs.pane.use({viewProjection:r.matrix,eye:e.camera.eye,exposure:e.exposure,panes:[0,n.TEXTURE_2D,s.panes.table]}),n.depthMask(!1),n.enable(n.BLEND),n.blendFunc(n.ONE,n.SRC_ALPHA),n.bindVertexArray(s.panes.array);for(let a=0;a<3;a++)this.programs.pane.set("band",a),n.colorMask(a===0,a===1,a===2,!1),this.drawElements(n.TRIANGLES,3*s.panes.count,0,zt);n.colorMask(!0,!0,!0,!0),n.disable(n.BLEND),n.depthMask(!0),n.bindVertexArray(null)}drawMedium(e,r,n,s){let{gl:a,scene:i}=this,{medium:o}=n,c=i.volume;a.viewport(0,0,o.width,o.height),i.panes&&(a.bindFramebuffer(a.FRAMEBUFFER,o.paneFrame),a.clearColor(1,1,1,6e4),a.clear(a.COLOR_BUFFER_BIT),a.enable(a.BLEND),a.blendEquationSeparate(a.FUNC_ADD,a.MIN),a.blendFuncSeparate(a.ZERO,a.SRC_COLOR,a.ONE,a.ONE),this.programs.tint.use({viewProjection:r.matrix,eye:e.camera.eye,ahead:r.forward,planes:[r.near,r.far],panes:[0,a.TEXTURE_2D,i.panes.table],depth:[1,a.TEXTURE_2D,n.depth],size:[o.width,o.height]}),a.bindVertexArray(i.panes.array),this.drawElements(a.TRIANGLES,3*i.panes.count,0,zt),a.blendEquation(a.FUNC_ADD),a.disable(a.BLEND)),a.bindFramebuffer(a.FRAMEBUFFER,o.frame),this.programs.medium.use({depth:[0,a.TEXTURE_2D,n.depth],paneTint:[1,a.TEXTURE_2D,o.paneTint],extinction:[2,a.TEXTURE_3D,c.extinction],radiosity:[3,a.TEXTURE_3D,c.radiosity],eye:e.camera.eye,...r.lens,low:c.min,high:c.max,density:e.density,exposure:e.exposure*c.unit/Math.PI,stride:c.cell*s.stride,maxSteps:s.steps,shift:s.jitter??0,hasPanes:!!i.panes,albedo:[_r,a.TEXTURE_3D,c.albedo],...this.sunUniforms({...e,part:"total"},s,1/c.unit)}),this.drawScreen()}linear(e,r,n,s){let{gl:a}=this,i=G(a,a.RGBA16F,a.RGBA,a.HALF_FLOAT,r,n,null),o=a.createFramebuffer();a.bindFramebuffer(a.FRAMEBUFFER,o),a.framebufferTexture2D(a.FRAMEBUFFER,a.COLOR_ATTACHMENT0,a.TEXTURE_2D,i,0),this.draw(e,r,n,s,o,"linear");let c=new Float32Array(4*r*n);return a.readPixels(0,0,r,n,a.RGBA,a.FLOAT,c),a.bindFramebuffer(a.FRAMEBUFFER,null),a.deleteFramebuffer(o),a.deleteTexture(i),c.map(u=>u/e.exposure)}};var re=t=>Number(t.toPrecision(6)),be=t=>t.map(re).join(",");function $t(t,e){let{camera:r}=t,n=new URLSearchParams;return n.set("eye",be(r.eye)),n.set("to",be(r.forward)),r.up[2]!==1&&n.set("up",be(r.up)),n.set("fov",re(r.fov)),t.mode!=="walk"&&n.set("mode",t.mode),t.stops&&n.set("ev",re(t.stops)),t.density!==1&&n.set("density",re(t.density)),t.show!=="picture"&&n.set("show",t.show),t.part!=="total"&&n.set("part",t.part),t.band!=="mean"&&n.set("band",t.band),t.log||n.set("scale","linear"),t.range&&n.set("range",be(t.range)),e.forEach((s,a)=>{t.factors[a]!==1&&n.set(`light.${s.name}`,re(t.factors[a]))}),`#${n.toString().replaceAll("%2C",",")}`}function Ht(t,e){let r=new URLSearchParams(t.replace(/^#/,"")),n=(d,m)=>{let v=(r.get(d)??"").split(",").map(p=>p.trim()===""?NaN:Number(p));return v.length===m&&v.every(p=>Number.isFinite(p)&&Math.abs(p)<1e30)?v:null},s=(d,m,v)=>{let p=n(d,1);return p&&p[0]>=m&&p[0]<=v?p[0]:null},a=(d,m)=>m.includes(r.get(d))?r.get(d):null,i={},o=n("eye",3),c=n("to",3),u=d=>Math.hypot(...d);if(o&&c&&u(c)>0){let d=n("up",3)??[0,0,1],m=b=>b.map(g=>g/(u(b)||1)),[v,p]=[m(c),m(d)],E=Math.abs(v[0]*p[0]+v[1]*p[1]+v[2]*p[2]);u(d)>0&&E<.99999&&(i.camera={eye:o,forward:v,up:p,fov:s("fov",1,150)??60})}let h=(d,m)=>{m!==null&&(i[d]=m)};h("mode",a("mode",["walk","orbit"])),h("stops",s("ev",-30,30)),h("density",s("density",0,1e3)),h("show",a("show",["picture","irradiance","radiosity","error"])),h("part",a("part",["total","direct","indirect"])),h("band",a("band",["mean","luminance","red","green","blue"])),r.get("scale")==="linear"&&(i.log=!1);let l=n("range",2);l&&l[1]>l[0]&&(i.range=l);let f=e.map(d=>s(`light.${d.name}`,0,1e6));return f.some(d=>d!==null)&&(i.factors=f.map(d=>d??1)),i}var z=t=>document.getElementById(t),Pr=matchMedia("(prefers-reduced-motion: reduce)"),ge=class{constructor(e,r,n,s){Object.assign(this,{gl:e,canvas:r,data:n,scene:s}),this.renderer=new Ee(e,s),this.small=matchMedia("(pointer: coarse)").matches||Math.min(screen.width,screen.height)<500,this.resolution=this.small?.75:1,this.base=1,this.pivot=P(n.bounds[0],n.bounds[1],.5),this.hideBacks=null,this.state={camera:this.initialCamera(),activeCamera:n.cameras.length?0:"overview",mode:n.cameras.length?"walk":"orbit",stops:0,density:1,factors:n.groups.map(()=>1),show:"picture",part:"total",band:"mean",log:!0,range:null},this.relit={field:null},this.readUrl(),this.panel=new ve(n,this.panelActions()),this.controls=new me(r,this.inputActions()),addEventListener("resize",()=>this.changed()),addEventListener("hashchange",()=>this.readUrl()&&this.changed()),document.addEventListener("visibilitychange",()=>this.changed()),this.relight(),this.base=this.automaticExposure(),this.last=0,this.changed()}replace(e,r){this.scene.free(),Object.assign(this,{data:e,scene:r,ends:null}),this.renderer.show(r),this.panel.report(e),this.relit.field=null,this.relight(),this.base=this.automaticExposure(),this.changed()}initialCamera(){let e=this.data.cameras[0];return e?fe(e):Ce(this.data.bounds,this.aspect())}aspect(){return this.canvas.clientWidth/Math.max(this.canvas.clientHeight,1)}readUrl(){let{origin:e,groups:r}=this.data,n=Ht(location.hash,r);return n.camera&&(n.camera.eye=N(n.camera.eye,e),n.activeCamera=void 0),Object.assign(this.state,n),n.factors&&(this.relit.field=null),Object.keys(n).length>0}writeUrl(){let e=this.state,r=$t({...e,camera:{...e.camera,eye:w(e.camera.eye,this.data.origin)}},this.data.groups);try{history.replaceState(null,"",r)}catch{}}set(e){Object.assign(this.state,e),("factors"in e||"show"in e||"part"in e)&&(this.relit.field=null),this.changed()}panelActions(){return{stops:e=>this.set({stops:e}),density:e=>this.set({density:e}),light:(e,r)=>this.set({factors:this.state.factors.map((n,s)=>s===e?r:n)}),lightsReset:()=>this.set({factors:this.state.factors.map(()=>1)}),show:e=>this.set({show:e,range:null}),part:e=>this.set({part:e,range:null}),band:e=>this.set({band:e,range:null}),log:e=>this.set({log:e}),range:e=>this.set({range:e}),mode:e=>this.setMode(e),camera:e=>this.flyTo(e),saveCamera:()=>Ft("camera.toml",Mt(this.sceneCamera())),copyCamera:async()=>{let e=_t(this.sceneCamera());this.panel.showCopied(await St(e)?`Copied: ${e}`:e)}}}sceneCamera(){let{eye:e,forward:r,up:n}=this.state.camera,s=te(this.data,e,r,this.backsHidden()),a=w(e,y(r,s?s.t:.3*this.renderer.diagonal)),{tanX:i}=C(this.state.camera,this.aspect()),o=360/Math.PI*Math.atan(i);return{origin:w(e,this.data.origin),target:w(a,this.data.origin),up:n,fov:o}}setMode(e){e==="orbit"&&this.choosePivot(),this.set({mode:e})}choosePivot(){let{eye:e,forward:r}=this.state.camera,n=te(this.data,e,r,this.backsHidden()),{diagonal:s}=this.renderer;this.pivot=w(e,y(r,n?n.t:.3*s))}backsHidden(){return this.hideBacks??this.state.mode==="orbit"}flyTo(e){let r=this.data.cameras[e],n=r?fe(r):Ce(this.data.bounds,this.aspect()),s=e==="overview"?"orbit":"walk";e==="overview"&&(this.pivot=P(this.data.bounds[0],this.data.bounds[1],.5));let a=Tt(this.state.camera);this.flight=Pr.matches?null:{from:a,goal:n,begin:performance.now()},this.set({activeCamera:e,mode:s,...this.flight?{}:{camera:n}})}move(e){this.flight=null,this.set({camera:e,activeCamera:void 0})}inputActions(){let e=()=>C(this.state.camera,this.aspect());return{changed:()=>this.changed(),look:(r,n)=>{let{tanX:s,tanY:a}=e(),i=this.state.camera;this.state.mode==="orbit"?this.move(Ie(i,this.pivot,-r*3.2,-n*2.4)):this.move(Oe(i,r*2*Math.atan(s),n*2*Math.atan(a)))},pan:(r,n)=>{let{tanX:s,tanY:a}=e(),i=this.state.mode==="orbit"?this.pivot:w(this.state.camera.eye,y(this.state.camera.forward,.25*this.renderer.diagonal)),o=At(this.state.camera,i,r,n,s,a);this.state.mode==="orbit"&&(this.pivot=o.pivot),this.move(o.camera)},zoom:r=>{let n=this.state.camera;this.state.mode==="orbit"?this.move(ze(n,this.pivot,r)):this.move({...n,eye:w(n.eye,y(n.forward,-Math.log(r)*.25*this.renderer.diagonal))})},tap:(r,n)=>this.probe(r,n),key:(r,n)=>this.key(r,n)}}key(e,r){let n=["picture",...Object.keys(pe)],s=/^(?:Digit|Numpad)([1-9])$/.exec(e);if(s)return this.data.cameras[s[1]-1]?(this.flyTo(Number(s[1])-1),!0):!1;if(r.key==="?")return z("help").showModal(),!0;if(r.key==="+"||r.key==="=")return this.set({stops:Math.min(this.state.stops+.5,8)}),!0;if(r.key==="-")return this.set({stops:Math.max(this.state.stops-.5,-8)}),!0;let a={KeyO:()=>this.setMode(this.state.mode==="walk"?"orbit":"walk"),KeyF:()=>this.set({show:n[(n.indexOf(this.state.show)+1)%n.length],range:null}),KeyM:()=>this.set({density:this.state.density>0?0:1}),KeyB:()=>{this.hideBacks=!this.backsHidden(),this.changed()},KeyH:()=>this.panel.toggle(),KeyP:()=>this.probe(.5,.5,!0),Digit0:()=>this.set({factors:this.state.factors.map(()=>1)}),Escape:()=>this.closeProbe()};return a[e]?.(),e in a}relight(){let{show:e,part:r}=this.state,n=e==="error"?"error":e==="picture"?"total":r;this.relit.field!==n&&(this.scene.relight(this.state.factors,n),this.relit.field=n,this.probeRay&&this.updateProbe())}frameSettings(e={}){let r=this.state;return{camera:r.camera,exposure:this.base*2**r.stops,density:r.density,show:r.show,part:r.part,band:r.band,log:r.log,range:r.show==="picture"?null:this.range(),hideBacks:this.backsHidden(),factors:r.factors,...e}}automaticExposure(){let e=this.frameSettings({camera:this.initialCamera(),exposure:1,show:"picture",hideBacks:!1}),r=this.renderer.linear({...e,exposure:this.provisionalExposure()},160,120,{mediumScale:.5,stride:1,steps:48});return gt(r)}provisionalExposure(){let e=this.patchValues("radiosity","mean"),r=e.reduce((n,s)=>n+s,0)/Math.max(e.length,1);return r>0?1/r:1}patchValues(e,r,n="total"){let s=We[r],a=this.data.counts.patches,i=new Float32Array(a);for(let o=0;o<a;o++){let c=ft(ue(this.data,o,this.state.factors),e,n);i[o]=s[0]*c[0]+s[1]*c[1]+s[2]*c[2]}return i}range(){let{show:e,part:r,band:n,log:s,range:a,factors:i}=this.state;if(a&&!(s&&a[0]<=0))return a;let o=`${e} ${r} ${n} ${i.join(" ")}`;if(this.ends?.key!==o){let h=this.patchValues(e,n,r).filter(f=>f>0&&Number.isFinite(f)).sort(),l=f=>h[Math.floor((h.length-1)*f)]??1;this.ends={key:o,low:l(.05),high:l(.995)}}let c=a?a[1]:this.ends.high,u=a?c/1e3:s?Math.max(this.ends.low,c/1e3):0;return[u<c?u:c/10,c>0?c:1]}probe(e,r,n=!1){let s=ct(C(this.state.camera,this.aspect()),e,r);return this.probeRay={eye:[...this.state.camera.eye],dir:s,at:[e,r]},z("cross").hidden=!n,this.updateProbe(),this.probeResult}updateProbe(){let{eye:e,dir:r,at:n}=this.probeRay;if(this.probeResult=Lt(this.data,this.state.factors,e,r,this.backsHidden()),!this.probeResult)return this.closeProbe();let{here:s}=this.probeResult,a=this.probeResult.back?-1:1,i=.02*this.renderer.diagonal,o={eye:N(this.probeResult.point,y(r,a*Math.min(i,this.probeResult.distance))),forward:y(r,a),up:Math.abs(r[2])<.9?[0,0,1]:[0,1,0],fov:.02},c=h=>{let l=this.frameSettings({camera:o,density:0,withoutPanes:!0,exposure:this.provisionalExposure(),...h});return[...this.renderer.linear(l,2,2,{mediumScale:1,steps:1,stride:1,sunSamples:256}).subarray(0,3)]};this.scene.suns.count&&(s.direct=w(s.direct,c({show:"irradiance",part:"sun"}))),s.irradiance=w(s.indirect,s.direct),this.relit.field==="total"&&!this.probeResult.back&&(s.radiosity=c({show:"picture"}).map(h=>h*Math.PI));let u=z("probe");return Ut(u,this.probeResult,()=>this.closeProbe()),u.classList.toggle("above",n[1]>.45),u.classList.toggle("aside",n[1]>.4&&n[0]<.4),document.body.classList.add("probing"),this.changed(),this.probeResult}closeProbe(){return this.probeRay=null,this.probeResult=null,z("probe").hidden=!0,z("mark").hidden=!0,z("cross").hidden=!0,document.body.classList.remove("probing"),null}placeMark(){if(!this.probeResult)return;let e=this.canvas.getBoundingClientRect(),r=ut(C(this.state.camera,e.width/e.height),this.state.camera.eye,this.probeResult.point),n=r&&r.every(s=>s>0&&s<1);z("mark").hidden=!n,n&&(z("mark").style.left=`${r[0]*e.width}px`,z("mark").style.top=`${r[1]*e.height}px`)}changed(){this.restAt=performance.now()+160,this.dirty=!0,this.frameRequested||(this.frameRequested=!0,requestAnimationFrame(e=>this.tick(e)))}advance(e){let r=Math.min((e-this.last)/1e3,.1);if(this.flight){let i=Math.min((e-this.flight.begin)/700,1);return this.state.camera=Rt(this.flight.from,this.flight.goal,Math.max(i,0)),i>=1&&(this.flight=null),!0}if(!this.controls.active)return!1;let n=this.controls.motion(),s=.07*this.renderer.diagonal*(this.controls.fast?4:1)*r,a=Oe(this.state.camera,n.yaw*1.4*r,n.pitch*1*r);return this.state.mode==="orbit"?(a=Ie(this.state.camera,this.pivot,(n.right-n.yaw)*1.2*r,-(n.up+n.pitch)*r),a=ze(a,this.pivot,Math.exp(-n.ahead*r))):a=wt(a,n.ahead*s,n.right*s,n.up*s),Object.assign(this.state,{camera:a,activeCamera:void 0}),!0}tick(e){if(this.frameRequested=!1,this.gl.isContextLost())return;let r=this.advance(e);this.last=e;let n=!r&&performance.now()>=this.restAt;this.frame(n),r?this.changed():n?this.writeUrl():(clearTimeout(this.restTimer),this.restTimer=setTimeout(()=>{this.frameRequested=!0,requestAnimationFrame(s=>this.tick(s))},180))}frame(e){let r=Math.min(devicePixelRatio||1,this.small?1.5:2)*(e?1:this.resolution),n=Math.max(1,Math.round(this.canvas.clientWidth*r)),s=Math.max(1,Math.round(this.canvas.clientHeight*r));(this.canvas.width!==n||this.canvas.height!==s)&&Object.assign(this.canvas,{width:n,height:s});let a=performance.now();this.relight();let i=this.frameSettings();this.renderer.draw(i,n,s,this.quality(e,n*s)),this.panel.update(this.state,i.range),this.placeMark(),e||this.adaptResolution(performance.now()-a),this.frames=(this.frames??0)+1}quality(e,r){let n=this.small?.5:1;return e?{mediumScale:r<2e5?1:.5,steps:160*n,stride:.5,sunSamples:this.small?16:32}:{mediumScale:this.small?.25:.4,steps:48*n,stride:1.2,sunSamples:8}}adaptResolution(e){if((this.frames??0)%6===0){let r=performance.now();this.gl.readPixels(0,0,1,1,this.gl.RGBA,this.gl.UNSIGNED_BYTE,new Uint8Array(4));let n=e+performance.now()-r;n>45?this.resolution=Math.max(.3,this.resolution*.8):n<14&&(this.resolution=Math.min(1,this.resolution*1.15))}}linear(e,r,n){this.relight();let s=this.data.cameras.find(c=>c.name===e),a=s?fe(s):this.state.camera,i=this.renderer.linear(this.frameSettings({camera:a,show:"picture",hideBacks:!1}),r,n,{mediumScale:.5,steps:256,stride:.5,jitter:-1}),o=[];for(let c=n-1;c>=0;c--)for(let u=0;u<r;u++)o.push(...i.subarray(4*(c*r+u),4*(c*r+u)+3));return this.changed(),o}};var D=t=>document.getElementById(t);function Y(t,e,r=null){D("coverTitle").textContent=t,D("coverText").textContent=e,D("coverBar").hidden=r===null,r!==null&&(D("coverBar").setAttribute("aria-valuenow",String(Math.round(100*r))),D("coverBar").firstElementChild.style.width=`${100*r}%`)}var Xt=()=>new Promise(t=>setTimeout(t));function Dr(t){let e=t.getContext("webgl2",{antialias:!1,alpha:!1,depth:!1,powerPreference:"high-performance"});if(!e)throw new k("The viewer needs WebGL 2, which this browser or device does not provide. Current versions of Chrome, Edge, Firefox and Safari do, unless it is disabled in their settings.");if(!e.getExtension("EXT_color_buffer_float")&&!e.getExtension("EXT_color_buffer_half_float"))throw new k("The viewer needs half-float render targets (EXT_color_buffer_float), which this device does not provide.");return e}async function Ur(){let t=D("data"),e=s=>Y("Loading","Reading the solution…",.8*s),r=t?null:await nt(s=>Y("Solving",Se(s),s.fraction));if(r?.version===0)throw new k(r.error);let n=t?et(t.textContent.trim(),e):await _e("scene.bin",e);return t?.remove(),Y("Loading","Decompressing…",.82),await Xt(),{data:Me(await Re(n)),progress:r}}function Lr(t,e,r){let n=a=>{D("solving").textContent=a,D("solving").hidden=!a};st(e,n,async()=>{let a=Me(await Re(await _e("scene.bin")));if(!at(t.data,a))return location.reload();t.replace(a,await J.load(t.gl,a,()=>{},r)),t.version=(t.version??e)+1}).catch(a=>n(a.message||String(a)))}async function Br(){let t=D("canvas"),e=performance.now();try{let r=Dr(t),{data:n,progress:s}=await Ur();Y("Loading",`Preparing ${n.name}…`,.88),await Xt();let a=matchMedia("(pointer: coarse)").matches,i=await J.load(r,n,c=>Y("Loading",`Preparing ${n.name}…`,.88+.1*c),a);for(let c of["canvas","bar"])D(c).hidden=!1;let o=new ge(r,t,n,i);innerWidth>900&&o.panel.toggle(!0),D("cover").hidden=!0,t.addEventListener("webglcontextlost",c=>{c.preventDefault(),D("cover").hidden=!1,Y("Graphics context lost","The graphics card may be out of memory. Reload the page to continue; the address keeps the view.")}),o.loaded=performance.now()-e,window.zonal=o,s?.live&&Lr(o,s.version,a)}catch(r){r instanceof k||console.error(r),Y(r instanceof k?"The solution cannot be shown":"Unexpected error",r.message||String(r)),document.body.dataset.failed="1"}}Br();})();
